import math
from typing import Any

import pytest

from sitl.autopilot.control.limits import Limits
from sitl.autopilot.control.position_control import (
    AttitudeSetpoint,
    PositionControl,
    PositionParameters,
)
from sitl.autopilot.control.setpoint import Setpoint
from sitl.autopilot.parameters import Parameters
from sitl.frames import quaternion_from_euler, rotate, yaw_of
from sitl.records.sensing import Estimate

LIMITS = Limits(3.0, 1.5, math.tan(math.radians(45.0)), 0.12)
ZERO = (0.0, 0.0, 0.0)
NAN = math.nan
PARAMETERS = PositionParameters.resolve(Parameters({"MPC_THR_HOVER": 0.6}).values)


def estimate(
    position: tuple[float, float, float] = ZERO,
    velocity: tuple[float, float, float] = ZERO,
    yaw_rad: float = 0.0,
    z_deriv_m_s: float = NAN,
) -> Estimate:
    return Estimate(
        time_us=0,
        position_ned=position,
        velocity_ned=velocity,
        q_ned_frd=quaternion_from_euler(0.0, 0.0, yaw_rad),
        rates_frd=ZERO,
        specific_force_frd=(0.0, 0.0, -9.80665),
        attitude_valid=True,
        position_valid=True,
        altitude_valid=True,
        z_deriv_m_s=z_deriv_m_s,
    )


@pytest.fixture
def control() -> PositionControl:
    return PositionControl(PARAMETERS)


def follow(
    control: PositionControl, setpoint: Setpoint, limits: Limits = LIMITS, **state: Any
) -> AttitudeSetpoint:
    return control.update(estimate(**state), setpoint, limits, PARAMETERS, learns=False)


def test_hover_takes_hover_thrust_and_level_attitude(control: PositionControl) -> None:
    asked = follow(control, Setpoint(velocity_ned=ZERO, yaw_rad=0.7))
    assert asked.thrust == pytest.approx(0.6)
    assert asked.q_ned_frd == pytest.approx(quaternion_from_euler(0.0, 0.0, 0.7))


@pytest.mark.parametrize("yaw_rad", [0.0, 1.0, 3.0, -2.5])
def test_thrust_points_where_the_acceleration_leads(
    control: PositionControl, yaw_rad: float
) -> None:
    asked = follow(control, Setpoint(velocity_ned=(0.5, -0.25, 0.0), yaw_rad=yaw_rad))
    x, y, z = rotate(asked.q_ned_frd, (0.0, 0.0, -1.0))
    assert (x / -z, y / -z) == pytest.approx((1.8 * 0.5 / 9.80665, -1.8 * 0.25 / 9.80665))
    assert yaw_of(asked.q_ned_frd) == pytest.approx(yaw_rad)


def test_position_error_becomes_velocity(control: PositionControl) -> None:
    asked = follow(control, Setpoint(position_ned=(1.0, 0.0, -1.0)))
    assert asked.velocity_ned == pytest.approx((0.95, 0.0, -1.0))


@pytest.mark.parametrize(
    ("wanted", "z_deriv_m_s", "held_m_s"),
    [
        (-1.0, 0.3, 0.3),
        (0.35, 0.3, 0.2),  # half of MPC_LAND_SPEED: half of each
        (0.0, 0.3, 0.1),
        (1.0, NAN, 0.1),
    ],
)
def test_a_climb_by_velocity_is_held_against_the_rate_of_the_position(
    control: PositionControl, wanted: float, z_deriv_m_s: float, held_m_s: float
) -> None:
    state: dict[str, Any] = {"velocity": (0.0, 0.0, 0.1), "z_deriv_m_s": z_deriv_m_s}
    asked = follow(control, Setpoint(velocity_ned=(0.0, 0.0, wanted)), **state)
    assert asked.acceleration_ned[2] == pytest.approx(4.0 * (wanted - held_m_s))
    with_height = Setpoint(position_ned=(NAN, NAN, 0.0), velocity_ned=(0.0, 0.0, wanted))
    asked = follow(PositionControl(PARAMETERS), with_height, **state)
    assert asked.acceleration_ned[2] == pytest.approx(4.0 * (wanted - 0.1))


def test_velocity_is_added_to_what_position_asks(control: PositionControl) -> None:
    asked = follow(control, Setpoint(position_ned=(1.0, 0.0, 0.0), velocity_ned=(0.5, 1.0, 0.2)))
    assert asked.velocity_ned == pytest.approx((1.45, 1.0, 0.2))


def test_horizontal_speed_is_limited_and_position_is_served_first(control: PositionControl) -> None:
    asked = follow(control, Setpoint(position_ned=(10.0, 0.0, 0.0), velocity_ned=(0.0, 20.0, 0.0)))
    vx, vy, _ = asked.velocity_ned
    assert vx == pytest.approx(9.5)
    assert math.hypot(vx, vy) == pytest.approx(12.0)
    far = follow(control, Setpoint(position_ned=(100.0, 0.0, 0.0), velocity_ned=(0.0, 5.0, 0.0)))
    assert far.velocity_ned[:2] == pytest.approx((12.0, 0.0))


def test_vertical_speed_is_limited_both_ways(control: PositionControl) -> None:
    assert follow(control, Setpoint(velocity_ned=(0.0, 0.0, -9.0))).velocity_ned[2] == -3.0
    assert follow(control, Setpoint(velocity_ned=(0.0, 0.0, 9.0))).velocity_ned[2] == 1.5


def test_tilt_is_limited(control: PositionControl) -> None:
    asked = follow(control, Setpoint(velocity_ned=(12.0, 0.0, 0.0)))
    x, y, z = rotate(asked.q_ned_frd, (0.0, 0.0, -1.0))
    assert math.degrees(math.atan2(math.hypot(x, y), -z)) <= 45.0 + 1e-6


def test_height_is_served_before_horizontal_motion(control: PositionControl) -> None:
    limits = LIMITS._replace(speed_up_m_s=8.0)
    asked = follow(control, Setpoint(velocity_ned=(12.0, 0.0, -8.0)), limits)
    assert asked.thrust == pytest.approx(1.0)
    up = asked.thrust * -rotate(asked.q_ned_frd, (0.0, 0.0, -1.0))[2]
    assert up == pytest.approx(math.sqrt(1.0 - 0.3**2), abs=1e-6)  # MPC_THR_XY_MARG stays


def test_axes_without_a_setpoint_are_left_alone(control: PositionControl) -> None:
    asked = follow(control, Setpoint(acceleration_ned=(1.0, 0.0, 0.0)), velocity=(3.0, 0.0, 0.0))
    assert all(math.isnan(speed) for speed in asked.velocity_ned)
    assert asked.acceleration_ned == pytest.approx((1.0, 0.0, 0.0))


def test_heading_without_a_setpoint_is_the_present_one(control: PositionControl) -> None:
    asked = follow(control, Setpoint(velocity_ned=ZERO, yaw_rate_rad_s=0.3), yaw_rad=1.2)
    assert asked.yaw_rad == pytest.approx(1.2)
    assert asked.yaw_rate_rad_s == 0.3


def test_integral_grows_with_the_error(control: PositionControl) -> None:
    for _ in range(250):
        follow(control, Setpoint(velocity_ned=(1.0, 0.0, 0.0)))
    assert control.state.integral == pytest.approx((0.4, 0.0, 0.0), rel=0.01)


def test_integral_does_not_wind_up_at_full_thrust(control: PositionControl) -> None:
    limits = LIMITS._replace(speed_up_m_s=8.0)
    for _ in range(500):
        follow(control, Setpoint(velocity_ned=(0.0, 0.0, -8.0)), limits)
    assert control.state.integral[2] == 0.0


def test_integral_does_not_wind_up_at_the_tilt_limit(control: PositionControl) -> None:
    for _ in range(2500):
        follow(control, Setpoint(velocity_ned=(12.0, 0.0, 0.0)))
    assert abs(control.state.integral[0]) < 1.1  # without care it would be 0.4 * 12 * 10 s


def test_take_off_ramp_teaches_nothing(control: PositionControl) -> None:
    limits = Limits(-2.0, 1.5, 0.2, 0.001)
    for _ in range(250):
        follow(control, Setpoint(velocity_ned=(0.0, 0.0, -1.0)), limits)
    assert control.state.integral[2] == 0.0
