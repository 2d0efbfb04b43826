"""The script that flies the expert itself, blind before a gate where that is asked for."""

import math

import numpy as np
import pytest

from flightstack.training.data.funnel import ExpertConfig, FunnelExpert
from scripts.fly_expert import BlindExpert, fly
from sitl import (
    Conditions,
    EstimateErrors,
    Gate,
    SimulationConfig,
    VehicleState,
    quaternion_from_euler,
)

GATE = Gate(index=0, centre_ned=(5.0, 0.0, -3.0), yaw_rad=0.0)
NEXT = Gate(index=1, centre_ned=(10.0, 3.0, -3.0), yaw_rad=math.radians(45.0))
BLIND = BlindExpert(ExpertConfig(), blind_m=0.8)


def state(north_m: float, yaw_rad: float = 0.0) -> VehicleState:
    q = quaternion_from_euler(0.0, 0.0, yaw_rad)
    return VehicleState(0, (north_m, 0.2, -2.9), (0.0,) * 3, q, (0.0,) * 3, (0.0,) * 3)


def test_it_is_the_expert_until_the_camera_sees_no_more_of_the_gate() -> None:
    far = state(4.1)
    expected = FunnelExpert().command(far, GATE, NEXT)
    assert np.array_equal(BLIND.command(far, GATE, NEXT), expected)


@pytest.mark.parametrize("yaw_rad", [0.0, 0.4])
def test_blind_it_flies_straight_along_the_axis(yaw_rad: float) -> None:
    vx, vy, vz, _ = BLIND.command(state(4.3, yaw_rad), GATE, NEXT)
    along = (
        math.cos(yaw_rad) * vx - math.sin(yaw_rad) * vy,
        math.sin(yaw_rad) * vx + math.cos(yaw_rad) * vy,
        vz,
    )
    assert along == pytest.approx((2.0, 0.0, 0.0))


def test_it_passes_a_lap_on_a_calm_day_and_drifts_off_course_with_rotor_noise() -> None:
    calm = SimulationConfig(track_seed=20_000_000, noise_m=(1.5, 3.0), laps=1)
    assert fly(calm, BlindExpert(ExpertConfig(), blind_m=0.0)) == 8
    shaken = SimulationConfig(
        track_seed=20_000_000,
        noise_m=(1.5, 3.0),
        laps=1,
        conditions=Conditions(estimate=EstimateErrors(rotor_noise_share=1.0)),
    )
    assert fly(shaken, BlindExpert(ExpertConfig(), blind_m=0.0)) < 8
