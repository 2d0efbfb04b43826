"""One flight in process, an image at a time: vehicle, camera, course and day of `python -m sitl`.

It begins in the air over the spawn point, at the gates' height, in OFFBOARD. A command holds from
one image to the next, as in lockstep; it is answered to at the moment of its image.
"""

import math
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from flightstack.arrays import PerVelocity
from flightstack.frames import body_from_ned, ned_from_body
from flightstack.records import Observation
from sitl import (
    GATE_HEIGHT_M,
    Conditions,
    CourseState,
    Estimate,
    Gate,
    OffboardSetpoint,
    Simulation,
    SimulationConfig,
    euler_from_quaternion,
    parse_conditions,
    wrap_pi,
    yaw_of,
)

SPAWN_NED = (0.0, 0.0, -GATE_HEIGHT_M)
KEPT = 128  # estimates, one a tick: half a second, longer than a camera may be late


@dataclass(frozen=True, slots=True, kw_only=True)
class CourseRequest:
    """What is flown, but for its seeds."""

    noise_m: tuple[float, float]  # of the gates' radius and height
    direction: str  # "cw" or "ccw", seen from above
    laps: int
    conditions: Conditions


class GateFlight:
    """A flight of one vehicle around one course; for one thread."""

    def __init__(self, request: CourseRequest, *, seed: int, track_seed: int) -> None:
        """Start it and wait for the first image; raises what the simulation refuses."""
        self._simulation = Simulation(
            SimulationConfig(
                seed=seed,
                track_seed=track_seed,
                noise_m=request.noise_m,
                direction="cw" if request.direction == "cw" else "ccw",
                laps=request.laps,
                conditions=request.conditions,
            )
        )
        self._simulation.start_airborne(SPAWN_NED, 0.0)
        self._estimates = deque([self._simulation.estimate], maxlen=KEPT)
        self.observation = self._next_observation()  # what a policy is told, as the wire tells it

    def close(self) -> None:
        """Free the physics engine and the renderer."""
        self._simulation.close()

    def fly(self, velocities: PerVelocity) -> None:
        """Fly by forward, right, down (m/s) and yaw rate (rad/s) until the next image is there."""
        vx, vy, vz, yaw_rate = velocities.tolist()
        autopilot = self._simulation.autopilot
        autopilot.offboard_setpoint(
            OffboardSetpoint(
                time_us=self._simulation.time_us,
                velocity_ned=ned_from_body((vx, vy, vz), autopilot.yaw_rad),
                yaw_rate_rad_s=yaw_rate,
            )
        )
        self._step()
        self.observation = self._next_observation()

    @property
    def elapsed_s(self) -> float:
        """Vehicle time since the start."""
        return self._simulation.time_us / 1e6

    @property
    def height_m(self) -> float:
        """Above the ground, in truth."""
        return -self._simulation.state.position_ned[2]

    @property
    def state(self) -> CourseState:
        """Where the course stands, as the referee says."""
        return self._simulation.course.state

    @property
    def gates(self) -> tuple[int, int]:
        """How many are passed, and how many there are in all laps."""
        course = self._simulation.course
        return course.gates_passed, course.gates_total

    @property
    def due_gate(self) -> tuple[float, float, float, float]:
        """Where the next gate is, in truth: forward, right, down (m), and its axis (rad).

        From the vehicle, along its heading; the axis is that along which it is to be passed.
        """
        state, gate = self._simulation.state, self._due()
        yaw = yaw_of(state.q_ned_frd)
        north, east, down = (
            there - here for there, here in zip(gate.centre_ned, state.position_ned, strict=True)
        )
        return (*body_from_ned((north, east, down), yaw), wrap_pi(gate.yaw_rad - yaw))

    @property
    def distance_m(self) -> float:
        """From the vehicle to the middle of the next gate, in truth."""
        return math.dist(self._simulation.state.position_ned, self._due().centre_ned)

    def drain_events(self) -> list[str]:
        """Return what the referee has said since the last call."""
        return [event.kind.value for event in self._simulation.drain_course_events()]

    def _due(self) -> Gate:
        gates = self._simulation.course_gates
        return gates[self._simulation.course.gates_passed % len(gates)]

    def _step(self) -> None:
        self._simulation.step()
        self._estimates.append(self._simulation.estimate)

    def _next_observation(self) -> Observation:
        """Fly on to the next image; returns it with what was estimated at its moment."""
        while not self._simulation.image_due():
            self._step()
        image = self._simulation.render()
        estimate = self._estimate_at(image.time_us)
        roll, pitch, yaw = euler_from_quaternion(estimate.q_ned_frd)
        return Observation(
            stamp_us=image.time_us,
            image=image.rgb,
            velocity=np.array(body_from_ned(estimate.velocity_ned, yaw), np.float32),
            attitude=np.array((roll, pitch, yaw), np.float32),
        )

    def _estimate_at(self, stamp_us: int) -> Estimate:
        """Return what was estimated at that tick, or first of all where that is long ago."""
        for estimate in reversed(self._estimates):
            if estimate.time_us <= stamp_us:
                return estimate
        return self._estimates[0]


def read_day(conditions: Mapping[str, Any]) -> Conditions:
    """Read conditions as `flightstack.fly` takes them; raises the simulation's UsageError."""
    table: dict[str, Any] = {}
    for key, value in conditions.items():
        part, _, name = key.partition(".")
        table.setdefault(part, {})[name] = list(value) if isinstance(value, tuple) else value
    return parse_conditions(table, "conditions")
