import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sitl.autopilot.control.attitude_control import AttitudeParameters, turning_rates
from sitl.autopilot.parameters import Parameters
from sitl.frames import quaternion_from_euler

PARAMETERS = AttitudeParameters.resolve(Parameters().values)
ANGLES = st.floats(-math.pi, math.pi)
LEVEL = quaternion_from_euler(0.0, 0.0, 0.0)
SMALL = 0.02  # rad


@pytest.mark.parametrize(
    ("euler", "rates"),
    [
        ((SMALL, 0.0, 0.0), (4.0 * SMALL, 0.0, 0.0)),
        ((0.0, SMALL, 0.0), (0.0, 4.0 * SMALL, 0.0)),
        ((0.0, 0.0, SMALL), (0.0, 0.0, 2.8 * SMALL)),
    ],
)
def test_small_errors_are_met_with_the_gains(
    euler: tuple[float, float, float], rates: tuple[float, float, float]
) -> None:
    wanted = quaternion_from_euler(*euler)
    assert turning_rates(LEVEL, wanted, 0.0, PARAMETERS) == pytest.approx(rates, rel=1e-3, abs=1e-6)


@given(roll=st.floats(-1.4, 1.4), pitch=st.floats(-1.4, 1.4), yaw=ANGLES)
def test_no_error_asks_for_no_rate(roll: float, pitch: float, yaw: float) -> None:
    q = quaternion_from_euler(roll, pitch, yaw)
    assert turning_rates(q, q, 0.0, PARAMETERS) == pytest.approx((0.0, 0.0, 0.0), abs=1e-6)


@given(roll=ANGLES, pitch=st.floats(-1.5, 1.5), yaw=ANGLES, rate=st.floats(-3.0, 3.0))
def test_rates_stay_within_their_limits(roll: float, pitch: float, yaw: float, rate: float) -> None:
    wanted = quaternion_from_euler(roll, pitch, yaw)
    p, q, r = turning_rates(LEVEL, wanted, rate, PARAMETERS)
    assert max(abs(p), abs(q)) <= math.radians(220.0) + 1e-6
    assert abs(r) <= math.radians(200.0) + 1e-6


@given(tilt=st.floats(0.2, 1.0), yaw=st.floats(-3.0, 3.0))
def test_either_sign_of_the_quaternion_means_the_same(tilt: float, yaw: float) -> None:
    wanted = quaternion_from_euler(tilt, 0.0, yaw)
    w, x, y, z = wanted
    assert turning_rates(LEVEL, wanted, 0.0, PARAMETERS) == pytest.approx(
        turning_rates(LEVEL, (-w, -x, -y, -z), 0.0, PARAMETERS)
    )


def test_yaw_rate_feeds_forward_about_the_vertical() -> None:
    assert turning_rates(LEVEL, LEVEL, 0.5, PARAMETERS) == pytest.approx((0.0, 0.0, 0.5))
    pitched = quaternion_from_euler(0.0, 0.3, 0.0)
    assert turning_rates(pitched, pitched, 0.5, PARAMETERS) == pytest.approx(
        (-0.5 * math.sin(0.3), 0.0, 0.5 * math.cos(0.3)), abs=1e-6
    )


def test_without_weight_on_yaw_only_the_tilt_is_corrected() -> None:
    parameters = AttitudeParameters.resolve(Parameters({"MC_YAW_WEIGHT": 0.0}).values)
    wanted = quaternion_from_euler(0.5, 0.0, 2.0)
    p, q, r = turning_rates(LEVEL, wanted, 0.0, parameters)
    # The least turn that brings the thrust axis there: about the wanted roll axis, by the tilt.
    assert (p, q) == pytest.approx(
        (8.0 * math.sin(0.25) * math.cos(2.0), 8.0 * math.sin(0.25) * math.sin(2.0))
    )
    assert r == 0.0


def test_a_large_heading_error_does_not_hurry_the_tilt() -> None:
    wanted = quaternion_from_euler(0.5, 0.0, 2.0)
    p, q, r = turning_rates(LEVEL, wanted, 0.0, PARAMETERS)
    assert math.hypot(p, q) <= 8.0 * math.sin(0.25) + 1e-9
    assert 0.0 < r < 2.8 * 2.0


def test_upside_down_finds_its_way() -> None:
    wanted = quaternion_from_euler(math.pi, 0.0, 0.0)
    rates = turning_rates(LEVEL, wanted, 0.0, PARAMETERS)
    assert all(math.isfinite(rate) for rate in rates)
    assert math.hypot(*rates) > 1.0
