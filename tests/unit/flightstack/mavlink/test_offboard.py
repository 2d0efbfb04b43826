"""Setpoints say what the vehicle must read in them."""

import math

import pytest

from flightstack.mavlink.offboard import velocity_setpoint


def test_a_setpoint_is_a_body_velocity_with_the_stamp_of_its_image() -> None:
    setpoint = velocity_setpoint(3, 1_234_999, (1.0, -2.0, 0.5, 0.25))
    assert (setpoint.target_system, setpoint.target_component) == (3, 1)
    assert (setpoint.coordinate_frame, setpoint.type_mask) == (8, 0x5C7)
    assert setpoint.time_boot_ms == 1234
    velocities = (setpoint.vx, setpoint.vy, setpoint.vz, setpoint.yaw_rate)
    assert velocities == (1.0, -2.0, 0.5, 0.25)


def test_the_stamp_wraps_as_the_field_does() -> None:
    assert velocity_setpoint(1, (1 << 32) * 1000 + 5000, (0, 0, 0, 0)).time_boot_ms == 5


@pytest.mark.parametrize("wrong", [math.nan, math.inf, -math.inf])
def test_nothing_but_numbers_leaves(wrong: float) -> None:
    with pytest.raises(ValueError, match="not finite"):
        velocity_setpoint(1, 0, (0.0, 0.0, wrong, 0.0))
