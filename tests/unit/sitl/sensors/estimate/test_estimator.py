import math
from typing import Any

import numpy as np
import pytest

from sitl.frames import quaternion_from_euler, rotate_inverse
from sitl.records.motion import VehicleState
from sitl.records.sensing import Readings, SensorHealth
from sitl.sensors.estimate import drift, shaken
from sitl.sensors.estimate.drift import Drift, position_std
from sitl.sensors.estimate.estimator import Estimator, PerfectEstimator
from sitl.sensors.noise import normals
from sitl.sensors.suite import Sensors

ALL_WELL = SensorHealth()
ZERO = (0.0, 0.0, 0.0)


def state(time_us: int) -> VehicleState:
    return VehicleState(
        time_us=time_us,
        position_ned=(1.0, 2.0, -3.0),
        velocity_ned=(0.1, 0.2, 0.3),
        q_ned_frd=(1.0, 0.0, 0.0, 0.0),
        rates_frd=(0.01, 0.02, 0.03),
        specific_force_frd=(0.0, 0.0, -9.8),
    )


def readings(health: SensorHealth = ALL_WELL) -> Readings:
    return Sensors([0], altitude_m=0.0).update(state(0))._replace(health=health)


def make_estimator(seed: int = 0) -> Estimator:
    return Estimator(np.random.default_rng(seed), ZERO, ZERO)


@pytest.mark.parametrize(
    ("time_us", "attitude", "altitude", "position"),
    [
        (0, False, False, False),
        (196_000, False, False, False),
        (200_000, True, False, False),
        (600_000, True, True, False),
        (996_000, True, True, False),
        (1_000_000, True, True, True),
    ],
)
def test_becomes_valid_step_by_step(
    time_us: int, *, attitude: bool, altitude: bool, position: bool
) -> None:
    for estimate in (
        PerfectEstimator().update(state(time_us)),
        make_estimator().update(state(time_us), readings()),
    ):
        assert estimate.attitude_valid is attitude
        assert estimate.altitude_valid is altitude
        assert estimate.position_valid is position


@pytest.mark.parametrize(("settled_s", "position_s"), [(1.0, 1.0), (8.5, 3.0)])
def test_the_position_is_known_before_the_estimate_has_settled(
    settled_s: float, position_s: float
) -> None:
    late = Estimator(np.random.default_rng(0), ZERO, ZERO, settled_s=settled_s)
    perfect = PerfectEstimator(settled_s=settled_s)
    for give in (late.update, perfect.update):
        known = [give(state(t * 500_000), readings()) for t in range(20)]
        assert [e.position_valid for e in known] == [t * 0.5 >= position_s for t in range(20)]
        assert [e.settled for e in known] == [t * 0.5 >= settled_s for t in range(20)]


def test_a_start_in_the_air_is_aligned() -> None:
    late = make_estimator()
    late.align()
    for estimate in (
        PerfectEstimator(aligned=True).update(state(0)),
        late.update(state(0), readings()),
    ):
        assert estimate.attitude_valid
        assert estimate.position_valid
        assert estimate.altitude_valid
        assert estimate.settled


def test_the_perfect_estimate_is_the_state() -> None:
    assert PerfectEstimator().update(state(4000))[:6] == state(4000)


def test_is_one_tick_late() -> None:
    estimator = make_estimator()
    estimator.update(state(0), readings())
    jumped = state(4000)._replace(position_ned=(101.0, 2.0, -3.0))
    estimate = estimator.update(jumped, readings())
    assert estimate.time_us == 4000
    assert estimate.position_ned[0] == pytest.approx(1.0, abs=1.0)
    assert estimator.update(jumped, readings()).position_ned[0] == pytest.approx(101.0, abs=1.0)


def test_the_biases_of_the_inertial_unit_are_learnt() -> None:
    sensors = Sensors([5], altitude_m=0.0)
    imu = sensors.imu
    estimator = Estimator(np.random.default_rng(0), imu.gyro_bias_frd, imu.accelerometer_bias_frd)
    rates = [
        estimator.update(state(4000 * tick), sensors.update(state(4000 * tick))).rates_frd
        for tick in range(2000)
    ]
    assert np.mean(rates, axis=0) == pytest.approx((0.01, 0.02, 0.03), abs=1e-4)


def test_errors_are_as_large_as_in_a_hover_of_a_running_px4() -> None:
    errors = [Drift(normals(np.random.default_rng(seed))) for seed in range(200)]
    for error in errors:
        for _ in range(2500):
            error.advance(xy_aided=True, z_aided=True, heading_aided=True)
    positions = np.array([error.position_ned for error in errors])
    velocities = np.array([error.velocity_ned for error in errors])
    expected = position_std(drift.VELOCITY_XY, drift.PULL_XY_S)
    assert positions.std(axis=0)[:2] == pytest.approx(expected, rel=0.25)  # 5 sigma of 200
    assert 0.2 < math.hypot(expected, expected) < 0.3  # m, seen horizontally
    assert velocities.std(axis=0) == pytest.approx((0.06, 0.06, 0.02), rel=0.25)


def test_the_accuracy_is_told_and_grows_without_aid() -> None:
    estimator = make_estimator()
    estimator.align()
    aided = estimator.update(state(0), readings()).accuracy_m
    expected = position_std(drift.VELOCITY_XY, drift.PULL_XY_S)
    assert aided[0] == pytest.approx(math.sqrt(2.0) * expected)
    assert aided[1] == pytest.approx(position_std(drift.VELOCITY_Z, drift.PULL_Z_S))
    blind = readings(ALL_WELL._replace(gps=False))
    late = [estimator.update(state(t * 1_000_000), blind).accuracy_m for t in range(1, 6)]
    assert [x for x, _ in late] == sorted(x for x, _ in late)
    assert late[4][0] > 3.0 * aided[0]
    assert late[4][1] == aided[1]  # the barometer is still there
    assert estimator.update(state(6_000_000), readings()).accuracy_m == aided
    assert PerfectEstimator().update(state(0), blind).accuracy_m == (0.0, 0.0)


def test_the_velocity_error_is_what_moves_the_position_error() -> None:
    error = Drift(normals(np.random.default_rng(1)))
    x0 = error.position_ned[0]
    moved = pulled = 0.0
    for _ in range(250):
        pulled -= error.position_ned[0] / drift.PULL_XY_S * 0.004
        error.advance(xy_aided=True, z_aided=True, heading_aided=True)
        moved += error.velocity_ned[0] * 0.004
    assert error.position_ned[0] - x0 == pytest.approx(moved + pulled, abs=1e-9)


def test_the_attitude_error_is_a_small_turn() -> None:
    error = Drift(normals(np.random.default_rng(2)))
    q = quaternion_from_euler(0.3, -0.2, 2.0)
    turned = error.turn(q)
    assert math.hypot(*turned) == pytest.approx(1.0)
    assert abs(math.acos(min(1.0, abs(sum(a * b for a, b in zip(q, turned, strict=True)))))) < 0.05
    down, true_down = (rotate_inverse(each, (0.0, 0.0, 1.0)) for each in (turned, q))
    assert math.dist(down, true_down) < math.radians(0.15) * 5  # five sigma


def test_dead_reckoning_counts_for_five_seconds_and_the_position_comes_back_with_the_receiver() -> (
    None
):
    estimator = make_estimator()
    blind = readings(ALL_WELL._replace(gps=False))
    valid_until = 0
    estimator.align()
    estimator.update(state(0), readings())
    for tick in range(1, 5000):
        estimate = estimator.update(state(4000 * tick), blind)
        valid_until = 4000 * tick if estimate.position_valid else valid_until
    assert valid_until == 5_000_000 - 4000
    assert estimate.altitude_valid  # the barometer is still there
    lost_m = math.dist(estimate.position_ned, state(0).position_ned)
    back = estimator.update(state(20_000_000), readings())
    assert back.position_valid
    assert math.dist(back.position_ned, state(0).position_ned) < min(1.0, lost_m)


def test_height_needs_the_receiver_or_the_barometer() -> None:
    estimator = make_estimator()
    estimator.align()
    blind = readings(ALL_WELL._replace(gps=False, barometer=False))
    assert estimator.update(state(4_996_000), blind).altitude_valid
    assert not estimator.update(state(5_000_000), blind).altitude_valid


@pytest.mark.parametrize("sensor", ["gyro", "accelerometer"])
def test_nothing_is_valid_without_the_inertial_unit(sensor: str) -> None:
    estimator = make_estimator()
    estimator.align()
    estimate = estimator.update(state(4000), readings(ALL_WELL._replace(**{sensor: False})))
    assert not estimate.attitude_valid
    assert not estimate.position_valid
    assert estimate.sensors == ALL_WELL._replace(**{sensor: False})


@pytest.mark.parametrize(("sensor", "reading"), [("gyro", 0), ("accelerometer", 1)])
def test_a_shaken_estimate_is_as_good_as_before_once_its_inertial_unit_is_back(
    sensor: str, reading: int
) -> None:
    estimator = Estimator(np.random.default_rng(0), ZERO, ZERO, rotor_noise_share=1.0)
    estimator.align()
    well = readings()
    noisy: dict[str, Any] = {("rates_frd", "specific_force_frd")[reading]: (0.3, -3.0, 30.0)}
    wrong = well._replace(**noisy)
    ill = wrong._replace(health=ALL_WELL._replace(**{sensor: False}))
    for tick in range(250):  # not yet found out
        astray = estimator.update(state(4000 * tick), wrong)
    assert math.dist(astray.velocity_ned, state(0).velocity_ned) > 2.0
    for tick in range(250, 1000):
        lost = estimator.update(state(4000 * tick), ill)
    assert lost.velocity_ned[2] == pytest.approx(astray.velocity_ned[2], rel=0.6)  # no worse
    estimator.update(state(4_000_000), well)
    back = estimator.update(state(4_004_000), well)
    errors = np.subtract(back.velocity_ned, state(0).velocity_ned)
    assert abs(errors[2]) < 5.0 * shaken.VELOCITY_STD_M_S[1]
    assert np.abs(errors[:2]).max() < 5.0 * shaken.VELOCITY_STD_M_S[0]
    assert abs(back.position_ned[2] + 3.0) < 5.0 * shaken.POSITION_STD_M[1]
    _, x, y, _ = back.q_ned_frd
    assert 2.0 * math.hypot(x, y) < 5.0 * math.sqrt(2.0) * shaken.TILT_STD_RAD


def test_a_position_without_a_receiver_stays_lost_when_the_inertial_unit_is_back() -> None:
    estimator = Estimator(np.random.default_rng(0), ZERO, ZERO, rotor_noise_share=1.0)
    estimator.align()
    well, wrong = readings(), readings()._replace(specific_force_frd=(3.0, 0.0, -9.8))
    without = ALL_WELL._replace(gps=False)
    for tick in range(500):
        astray = estimator.update(state(4000 * tick), wrong._replace(health=without))
    lost_m = math.dist(astray.position_ned[:2], state(0).position_ned[:2])
    assert lost_m > 2.0
    ill = well._replace(health=without._replace(gyro=False))
    estimator.update(state(2_000_000), ill)
    back = estimator.update(state(2_004_000), well._replace(health=without))
    assert math.dist(back.position_ned[:2], state(0).position_ned[:2]) >= 0.9 * lost_m
