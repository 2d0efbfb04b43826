"""Flights by the noisy estimate: they wander as a real vehicle does, and repeat by the seed."""

import math
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from sitl.flown_vehicle import SimulationConfig
from sitl.records.vehicle import OffboardSetpoint
from sitl.sensors.imu import SHAKEN_GYRO_STD_RAD_S
from sitl.simulation import Simulation

HOVER = (0.0, 0.0, -3.0)


@pytest.fixture
def make() -> Iterator[Callable[..., Simulation]]:
    made: list[Simulation] = []

    def build(**config: Any) -> Simulation:
        made.append(Simulation(SimulationConfig(**config)))
        made[-1].start_airborne(HOVER, 0.0)
        return made[-1]

    yield build
    for simulation in made:
        simulation.close()


def hover(simulation: Simulation, seconds: float) -> list[tuple[float, float, float]]:
    """Hold a place by its estimate; the true places, once a tick."""
    places = []
    for tick in range(round(seconds * 250)):
        if tick % 12 == 0:
            simulation.autopilot.offboard_setpoint(
                OffboardSetpoint(time_us=simulation.time_us, position_ned=HOVER, yaw_rad=0.0)
            )
        simulation.step()
        places.append(simulation.state.position_ned)
    return places


def test_the_same_seed_is_the_same_flight(make: Callable[..., Any]) -> None:
    first, again, other = (hover(make(seed=seed), 2.0)[-1] for seed in (7, 7, 8))
    assert first == again
    assert math.dist(first, other) > 1e-3


def test_a_hover_wanders_within_what_was_seen(make: Callable[..., Any]) -> None:
    places = [place for seed in range(4) for place in hover(make(seed=seed), 20.0)]
    wander_m = math.sqrt(sum(x * x + y * y for x, y, _ in places) / len(places))
    assert 0.08 < wander_m < 0.4  # 0.2 to 0.3 m over minutes; 4 times 20 s scatter more
    assert max(math.hypot(x, y) for x, y, _ in places) < 1.0
    assert max(abs(z + 3.0) for _, _, z in places) < 0.5


def test_a_perfect_estimate_is_the_truth(make: Callable[..., Any]) -> None:
    simulation = make(seed=1, perfect_estimate=True)
    places = hover(simulation, 5.0)
    assert simulation.estimate[:6] == simulation.state
    assert max(math.dist(place, HOVER) for place in places) < 0.02


def test_the_estimate_is_close_to_the_truth_and_the_readings_are_of_this_tick(
    make: Callable[..., Any],
) -> None:
    simulation = make(seed=3)
    hover(simulation, 5.0)
    state, estimate = simulation.state, simulation.estimate
    assert 1e-3 < math.dist(estimate.position_ned, state.position_ned) < 1.0
    assert 1e-4 < math.dist(estimate.velocity_ned, state.velocity_ned) < 0.3
    assert simulation.readings.gps.time_us > state.time_us - 125_000 - 4000
    shake = math.hypot(*SHAKEN_GYRO_STD_RAD_S)
    assert math.dist(simulation.readings.rates_frd, state.rates_frd) < 5.0 * shake
