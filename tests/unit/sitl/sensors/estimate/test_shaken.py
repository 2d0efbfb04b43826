"""The errors of a shaken estimate are those of the filter that they stand for."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from sitl.clock import TICK_S
from sitl.frames import GRAVITY_M_S2
from sitl.sensors.estimate import shaken
from sitl.sensors.estimate.shaken import Pull, ShakenDrift
from sitl.sensors.imu import SHAKEN_ACCELEROMETER_STD_M_S2, SHAKEN_GYRO_STD_RAD_S
from sitl.sensors.noise import normals

Matrix = NDArray[np.float64]
STEP_S, RECEIVER_HZ, BAROMETER_HZ = 0.01, 8.0, 20.0
AIDED = {"xy_aided": True, "z_aided": True, "heading_aided": True}
MISREAD = ((0.3, -0.2, 0.5), (0.02, -0.01, 0.03))


def make(seed: int = 0, share: float = 1.0) -> ShakenDrift:
    return ShakenDrift(normals(np.random.default_rng(seed)), share=share)


def settled_gains(
    move: Matrix, noise: Matrix, doubt: Matrix, aids: dict[str, tuple[int, float, float]]
) -> dict[str, Matrix]:
    """Run a Kalman filter for a minute; each aid's gain: (measured state, variance, Hz)."""
    covariance, gains = doubt, {}
    for step in range(round(60.0 / STEP_S)):
        covariance = move @ covariance @ move.T + noise
        for name, (state, variance, rate_hz) in aids.items():
            if step % (1.0 / (rate_hz * STEP_S)) < 1.0:
                gain = covariance[:, state] / (covariance[state, state] + variance)
                covariance = covariance - np.outer(gain, covariance[state])
                gains[name] = gain
    return gains


def assert_pull(pull: Pull, by_velocity: float, by_position: float) -> None:
    assert pull == pytest.approx((by_velocity, by_position), rel=0.05)


def test_the_horizontal_pulls_are_the_gains_of_a_settled_filter() -> None:
    move = np.eye(5)  # position, velocity, tilt, biases of gyro and accelerometer
    move[0, 1], move[1, 2] = STEP_S, GRAVITY_M_S2 * STEP_S
    move[2, 3] = move[1, 4] = -STEP_S
    noise = np.diag(np.square(np.multiply((0.0, 0.35, 0.015, 0.001, 0.003), STEP_S)))
    doubt = np.diag(np.square((1.0, 0.5, 0.1, 0.1, 0.2)))  # at first; PX4 EKF2_*_INIT
    gains = settled_gains(
        move, noise, doubt, {"v": (1, 0.4**2, RECEIVER_HZ), "x": (0, 0.9**2, RECEIVER_HZ)}
    )
    for state, pull in enumerate((shaken.XY_POSITION, shaken.XY_VELOCITY, shaken.XY_TILT)):
        assert_pull(pull, RECEIVER_HZ * gains["v"][state], RECEIVER_HZ * gains["x"][state])


def test_the_vertical_pulls_are_the_gains_of_a_settled_filter() -> None:
    move = np.eye(3)  # position, velocity, bias of the accelerometer
    move[0, 1], move[1, 2] = STEP_S, -STEP_S
    noise = np.diag(np.square(np.multiply((0.0, 0.35, 0.003), STEP_S)))
    doubt = np.diag(np.square((1.0, 0.5, 0.2)))
    aids = {
        "v": (1, (1.5 * 0.4) ** 2, RECEIVER_HZ),
        "z": (0, 1.78**2, RECEIVER_HZ),
        "h": (0, 3.5**2, BAROMETER_HZ),
    }
    gains = settled_gains(move, noise, doubt, aids)
    for state, pull in enumerate((shaken.Z_POSITION, shaken.Z_VELOCITY)):
        by_height = RECEIVER_HZ * gains["z"][state] + BAROMETER_HZ * gains["h"][state]
        assert_pull(pull, RECEIVER_HZ * gains["v"][state], by_height)


def spread(rate: Matrix, noise: Matrix) -> Matrix:
    """Standard deviations of x' = rate x + white noise, after a long time (Lyapunov's equation)."""
    one = np.eye(len(rate))
    covariance = np.linalg.solve(np.kron(rate, one) + np.kron(one, rate), -noise.ravel())
    spread: NDArray[np.float64] = np.sqrt(covariance.reshape(rate.shape).diagonal())
    return spread


def horizontal_spread(accelerometer_std: float, gyro_std: float) -> Matrix:
    (vx, xx), (vv, xv), (vt, xt) = shaken.XY_POSITION, shaken.XY_VELOCITY, shaken.XY_TILT
    rate = np.array([[-xx, 1.0 - vx, 0.0], [-xv, -vv, GRAVITY_M_S2], [-xt, -vt, 0.0]])
    return spread(rate, np.diag([0.0, accelerometer_std**2, gyro_std**2]) * TICK_S)


def test_errors_are_told_as_large_as_the_noise_makes_them_and_as_a_px4_was_seen_to_wander() -> None:
    (ax, ay, az), (p, q, _) = SHAKEN_ACCELEROMETER_STD_M_S2, SHAKEN_GYRO_STD_RAD_S
    forward, sideways = horizontal_spread(ax, q), horizontal_spread(ay, p)
    position, velocity, tilt = np.sqrt((forward**2 + sideways**2) / 2.0)
    assert position == pytest.approx(shaken.POSITION_STD_M[0], rel=0.02)
    assert velocity == pytest.approx(shaken.VELOCITY_STD_M_S[0], rel=0.02)
    assert tilt == pytest.approx(shaken.TILT_STD_RAD, rel=0.02)
    (vz, zz), (vv, zv) = shaken.Z_POSITION, shaken.Z_VELOCITY
    rate = np.array([[-zz, 1.0 - vz], [-zv, -vv]])
    height, climb = spread(rate, np.diag([0.0, az**2]) * TICK_S)
    assert height == pytest.approx(shaken.POSITION_STD_M[1], rel=0.02)
    assert climb == pytest.approx(shaken.VELOCITY_STD_M_S[1], rel=0.02)
    wander_m, told_m = math.sqrt(2.0) * position, make().aided_m[0]
    assert wander_m == pytest.approx(told_m, rel=0.02)
    assert 0.18 < wander_m < 0.3  # 0.2 to 0.3 m were seen
    assert sideways[1] == pytest.approx(0.25, abs=0.05)  # "up to 0.3 m/s off for seconds"


def test_errors_are_as_large_as_is_told() -> None:
    misread = np.random.default_rng(5)
    errors = [make(seed) for seed in range(100)]
    for drift in errors:
        force = misread.normal(0.0, SHAKEN_ACCELEROMETER_STD_M_S2, (2500, 3)).tolist()
        rates = misread.normal(0.0, SHAKEN_GYRO_STD_RAD_S, (2500, 3)).tolist()
        for each_force, each_rate in zip(force, rates, strict=True):
            drift.feel(tuple(each_force), tuple(each_rate))
            drift.advance(**AIDED)
    five_sigma = 5.0 / math.sqrt(2 * len(errors))
    for figure, (horizontal, vertical) in {
        "position_ned": shaken.POSITION_STD_M,
        "velocity_ned": shaken.VELOCITY_STD_M_S,
    }.items():
        x, y, z = np.array([getattr(drift, figure) for drift in errors]).std(axis=0)
        assert math.hypot(x, y) / math.sqrt(2.0) == pytest.approx(horizontal, rel=five_sigma)
        assert z == pytest.approx(vertical, rel=five_sigma)


@pytest.mark.parametrize("aids", [AIDED, {**AIDED, "z_aided": False}])
def test_its_vertical_derivative_is_that_of_its_height(aids: dict[str, bool]) -> None:
    drift = make()
    for _ in range(5):
        before = drift.position_ned[2]
        drift.feel(*MISREAD)
        drift.advance(**aids)
        assert drift.z_deriv_m_s * TICK_S == pytest.approx(drift.position_ned[2] - before)


@pytest.mark.parametrize("figure", ["position_ned", "velocity_ned"])
def test_half_the_share_is_half_the_error(figure: str) -> None:
    whole, half = make(share=1.0), make(share=0.5)
    for drift in (whole, half):
        for _ in range(500):
            drift.feel(*MISREAD)
            drift.advance(**AIDED)
    assert np.multiply(getattr(half, figure), 2.0) == pytest.approx(getattr(whole, figure))


def apart(change: Callable[[ShakenDrift], object], seconds: float = 0.4) -> Matrix:
    """How much a change moves the velocity error, against a twin without it."""
    changed, twin = make(), make()
    for _ in range(round(seconds / TICK_S)):
        change(changed)
        changed.advance(**AIDED)
        twin.advance(**AIDED)
    return np.subtract(changed.velocity_ned, twin.velocity_ned)


def test_what_the_accelerometer_reads_too_much_drives_the_velocity() -> None:
    moved = apart(lambda drift: drift.feel((1.0, -2.0, 0.5), shaken.ZERO), 0.4)
    assert moved == pytest.approx((0.4, -0.8, 0.2), rel=0.15)


def test_a_tilt_error_lets_gravity_drive_the_velocity() -> None:
    """Rolled too far right, thrust seems to push right; pitched too far up, backwards."""
    moved = apart(lambda drift: drift.feel(shaken.ZERO, (0.1, 0.1, 0.0)), 0.4)
    fall = 0.5 * GRAVITY_M_S2 * 0.1 * 0.4**2
    assert moved == pytest.approx((-fall, fall, 0.0), rel=0.15, abs=1e-9)


def test_without_aid_velocity_runs_away_and_comes_back_with_the_receiver() -> None:
    drift = make(3)
    for _ in range(5000):
        drift.feel((0.2, 0.2, 0.2), shaken.ZERO)
        drift.advance(xy_aided=False, z_aided=False, heading_aided=True)
    assert math.hypot(*drift.velocity_ned) > 5.0
    drift.restart_xy()
    assert math.hypot(*drift.velocity_ned[:2]) < 6.0 * shaken.VELOCITY_STD_M_S[0]
