"""Velocity steps of the whole vehicle, noise included, fall where a running PX4's were seen.

Measured as there: setpoints in the body frame at 20 Hz, a step out of a hover at 10 m, the estimate
read at 50 Hz and turned by the heading at the step; then back to a stop. The bands are those of
PX4 1.17's SIH quadrotor with a drag of 0.1 N/(m/s): the least and the greatest of its runs, widened
by 15 %. Where only a median is known, it is widened. Of vertical steps there are no bands, only the
medians of two runs up and of two down (15 % and 4 % overshoot, 1.05 and 0.90 steady), and the page
asks to lie inside bands, not to match single figures. That the two differ by chance shows
`test_step_responses_as_observed`: so they are one band, and of their tilts (3 and 2.5 deg) the
greater is the limit. The medians of a few runs have to lie inside.
"""

import math
import statistics
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import pytest

from sitl.clock import Schedule
from sitl.flown_vehicle import SimulationConfig
from sitl.records.conditions import Conditions
from sitl.records.motion import Vector3
from sitl.records.sensing import Estimate
from sitl.records.vehicle import OffboardSetpoint
from sitl.simulation import Simulation

WIDER = 0.15
RUNS = 5
ZERO: Vector3 = (0.0, 0.0, 0.0)
FINE_DAY = Conditions()


class Figures(NamedTuple):
    """What was measured of a step: seconds, shares of the step, degrees."""

    t10_s: float
    t63_s: float
    t90_s: float
    rise_s: float
    overshoot: float
    steady: float
    tilt_deg: float
    stop_s: float
    turned_deg: float


class Bands(NamedTuple):
    """Where such figures should lie."""

    t10_s: tuple[float, float]
    t63_s: tuple[float, float]
    t90_s: tuple[float, float]
    rise_s: tuple[float, float]  # from 10 to 90 %
    overshoot: tuple[float, float]
    steady: tuple[float, float]  # mean of the last second
    tilt_deg: tuple[float, float] = (0.0, math.inf)  # greatest
    stop_s: tuple[float, float] = (0.0, math.inf)  # from the step back, until below 10 %
    turned_deg: tuple[float, float] = (0.0, math.inf)


HORIZONTAL_1 = Bands(
    (0.20, 0.32), (0.64, 0.84), (0.94, 1.22), (0.66, 0.92), (0.10, 0.21), (0.95, 1.15), (8.5, 8.5)
)._replace(stop_s=(1.2, 1.2))
HORIZONTAL_2 = Bands(
    (0.26, 0.27), (0.70, 0.73), (0.98, 1.19), (0.66, 0.92), (0.07, 0.20), (1.05, 1.13), (16.0, 16.0)
)._replace(stop_s=(1.2, 1.2))
VERTICAL = Bands(
    (0.08, 0.10), (0.26, 0.30), (0.42, 0.54), (0.32, 0.46), (0.04, 0.15), (0.90, 1.05), (0.0, 3.0)
)._replace(stop_s=(0.43, 0.46))
YAW_RATE = Bands(
    (0.12, 0.19), (0.45, 0.49), (0.76, 0.97), (0.56, 0.82), (0.02, 0.06), (0.95, 0.96)
)._replace(turned_deg=(94.0, 96.0))

STEPS = {
    "forward 1 m/s": ((1.0, 0.0, 0.0), 0.0, 4.0, HORIZONTAL_1),
    "back 1 m/s": ((-1.0, 0.0, 0.0), 0.0, 4.0, HORIZONTAL_1),
    "right 1 m/s": ((0.0, 1.0, 0.0), 0.0, 4.0, HORIZONTAL_1),
    "forward 2 m/s": ((2.0, 0.0, 0.0), 0.0, 4.0, HORIZONTAL_2),
    "left 2 m/s": ((0.0, -2.0, 0.0), 0.0, 4.0, HORIZONTAL_2),
    "up 1 m/s": ((0.0, 0.0, -1.0), 0.0, 3.0, VERTICAL),
    "up 2 m/s": ((0.0, 0.0, -2.0), 0.0, 3.0, VERTICAL),
    "down 1 m/s": ((0.0, 0.0, 1.0), 0.0, 3.0, VERTICAL),
    "right about 0.5 rad/s": (ZERO, 0.5, 4.0, YAW_RATE),
    "left about 0.5 rad/s": (ZERO, -0.5, 4.0, YAW_RATE),
}


class Run:
    """One vehicle in a hover at 10 m, steered by a stream of body velocities."""

    def __init__(self, seed: int, conditions: Conditions = FINE_DAY) -> None:
        self.simulation = Simulation(SimulationConfig(seed=seed, conditions=conditions))
        self.simulation.start_airborne((0.0, 0.0, -10.0), 0.0)
        self._setpoints, self._samples = Schedule(20), Schedule(50)

    def stream(
        self, forward_right_down: Vector3, yaw_rate: float, seconds: float
    ) -> list[Estimate]:
        """Steer, and give the estimates at 50 Hz."""
        simulation = self.simulation
        samples: list[Estimate] = []
        forward, right, down = forward_right_down
        end_us = simulation.time_us + round(seconds * 1e6)
        while simulation.time_us < end_us:
            if self._setpoints.due(simulation.time_us):
                north, east = turned(forward, right, simulation.autopilot.yaw_rad)
                simulation.autopilot.offboard_setpoint(
                    OffboardSetpoint(
                        time_us=simulation.time_us,
                        velocity_ned=(north, east, down),
                        yaw_rate_rad_s=yaw_rate,
                    )
                )
            simulation.step()
            if self._samples.due(simulation.time_us):
                samples.append(simulation.estimate)
        return samples


@pytest.fixture
def make_run() -> Iterator[Callable[..., Run]]:
    made: list[Run] = []

    def make(seed: int) -> Run:
        made.append(Run(seed))
        return made[-1]

    yield make
    for run in made:
        run.simulation.close()


def turned(x: float, y: float, angle_rad: float) -> tuple[float, float]:
    cos, sin = math.cos(angle_rad), math.sin(angle_rad)
    return cos * x - sin * y, sin * x + cos * y


def tilt_deg(estimate: Estimate) -> float:
    _, x, y, _ = estimate.q_ned_frd
    return math.degrees(math.acos(1.0 - 2.0 * (x * x + y * y)))


def respond(
    run: Run, step: Vector3, yaw_rate: float, seconds: float, stopping_s: float = 2.0
) -> Figures:
    """Measure one step; the figures, in the order of the bands."""
    run.stream(ZERO, 0.0, 2.0)
    heading, start_us = run.simulation.autopilot.yaw_rad, run.simulation.time_us
    size = math.hypot(*step) or abs(yaw_rate)

    def share(estimate: Estimate) -> float:
        if yaw_rate:
            return estimate.rates_frd[2] / yaw_rate
        forward, right = turned(*estimate.velocity_ned[:2], -heading)
        body = (forward, right, estimate.velocity_ned[2])
        return sum(a * b for a, b in zip(body, step, strict=True)) / size**2

    def first(samples: list[Estimate], since_us: int, is_there: Callable[..., Any]) -> float:
        return next(((e.time_us - since_us) / 1e6 for e in samples if is_there(share(e))), math.inf)

    samples = run.stream(step, yaw_rate, seconds)
    shares = [share(estimate) for estimate in samples]
    t10, t63, t90 = (
        first(samples, start_us, lambda value, least=least: value >= least)
        for least in (0.10, 0.632, 0.90)
    )
    back_us = run.simulation.time_us
    stopping = run.stream(ZERO, 0.0, stopping_s)
    return Figures(
        t10,
        t63,
        t90,
        t90 - t10,
        max(shares) - 1.0,
        statistics.mean(shares[-50:]),
        max(tilt_deg(estimate) for estimate in samples),
        first(stopping, back_us, lambda value: abs(value) < 0.10),
        math.degrees(statistics.mean(shares) * seconds * abs(yaw_rate)),
    )


@pytest.mark.parametrize("name", STEPS)
def test_a_step_is_answered_as_px4_does(make_run: Callable[..., Any], name: str) -> None:
    step, yaw_rate, seconds, bands = STEPS[name]
    runs = [respond(make_run(seed), step, yaw_rate, seconds) for seed in range(RUNS)]
    for figure, values in zip(Bands._fields, zip(*runs, strict=True), strict=True):
        low, high = getattr(bands, figure)
        median = statistics.median(values)
        assert low * (1.0 - WIDER) <= median <= high * (1.0 + WIDER), (figure, values)


def test_a_yaw_step_hardly_overshoots_nor_drifts(make_run: Callable[..., Any]) -> None:
    """PX4: nothing seen beyond 3 deg over a step of 50 deg, a drift of 0.3 to 0.6 m."""
    run = make_run(1)
    simulation, wanted = run.simulation, math.radians(50.0)
    furthest = 0.0
    for tick in range(250 * 8):
        if tick % 12 == 0:
            simulation.autopilot.offboard_setpoint(
                OffboardSetpoint(time_us=simulation.time_us, velocity_ned=ZERO, yaw_rad=wanted)
            )
        simulation.step()
        furthest = max(furthest, simulation.autopilot.yaw_rad)
    assert math.degrees(furthest - wanted) < 3.0
    assert simulation.autopilot.yaw_rad == pytest.approx(wanted, abs=math.radians(2.0))
    assert math.hypot(*simulation.estimate.position_ned[:2]) < 0.6
