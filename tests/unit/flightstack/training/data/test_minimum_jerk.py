import numpy as np
import pytest

from flightstack.training.data.minimum_jerk import (
    ARRIVAL_SPEED_M_S,
    MAX_ACCELERATION_M_S2,
    MAX_SPEED_M_S,
    MinimumJerkExpert,
    plan,
)
from sitl import Gate, VehicleState, quaternion_from_euler

ZERO = (0.0, 0.0, 0.0)
GATE = Gate(index=0, centre_ned=(5.0, 1.0, -4.0), yaw_rad=0.3)
AFTER = Gate(index=1, centre_ned=(9.0, 5.0, -3.0), yaw_rad=1.1)


def at(
    position: tuple[float, float, float],
    velocity: tuple[float, float, float] = ZERO,
    time_us: int = 0,
) -> VehicleState:
    return VehicleState(time_us, position, velocity, quaternion_from_euler(0, 0, 0.0), ZERO, ZERO)


def test_a_segment_joins_the_state_to_the_gate_along_its_axis() -> None:
    segment = plan(at((0.0, 0.0, -3.0), (1.0, 0.2, 0.0)), GATE)
    assert segment.at(0.0) == pytest.approx((0.0, 0.0, -3.0))
    assert segment.at(0.0, 1) == pytest.approx((1.0, 0.2, 0.0))
    end = segment.duration_s
    assert segment.at(end) == pytest.approx(GATE.centre_ned)
    arrival = segment.at(end, 1)
    assert arrival == pytest.approx(
        (ARRIVAL_SPEED_M_S * np.cos(0.3), ARRIVAL_SPEED_M_S * np.sin(0.3), 0.0)
    )
    for derivative in (2,):
        assert segment.at(0.0, derivative) == pytest.approx(ZERO, abs=1e-9)
        assert segment.at(end, derivative) == pytest.approx(ZERO, abs=1e-9)


def test_limits_hold_on_the_way() -> None:
    segment = plan(at((0.0, -3.0, -3.0)), GATE)
    times = np.linspace(0.0, segment.duration_s, 500)
    assert max(np.linalg.norm(segment.at(t, 1)) for t in times) <= MAX_SPEED_M_S
    assert max(np.linalg.norm(segment.at(t, 2)) for t in times) <= MAX_ACCELERATION_M_S2 + 0.01


def test_near_a_gate_it_turns_to_the_following_one() -> None:
    expert = MinimumJerkExpert()
    far = expert.command(at((0.0, 0.0, -4.0)), GATE, AFTER)
    near = expert.command(at((4.8, 1.0, -4.0), (1.4, 0.4, 0.0), 2_000_000), GATE, AFTER)
    assert abs(far[3]) < 0.5
    assert near[3] > 0.5
