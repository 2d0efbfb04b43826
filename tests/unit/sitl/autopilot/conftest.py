"""A vehicle over flat ground, in process: body, estimator and autopilot, without sockets.

The estimate is the truth, so that a test of control measures the control; noise has tests of its
own, in `tests/unit/sitl/sensors` and `tests/unit/sitl/flights/test_noisy_flight.py`.
"""

import math
from collections.abc import Callable, Iterator

import pybullet
import pytest

from sitl.autopilot.autopilot import Autopilot
from sitl.autopilot.parameters import Parameters
from sitl.clock import TICK_US, Schedule
from sitl.frames import GRAVITY_M_S2, quaternion_from_euler
from sitl.records.motion import Vector3
from sitl.records.sensing import Estimate
from sitl.records.texts import StatusText
from sitl.records.vehicle import Command, OffboardSetpoint
from sitl.sensors.estimate.estimator import PerfectEstimator
from sitl.world.airframe import load_airframe
from sitl.world.body import QuadrotorBody

HOME = (47.397742, 8.545594, 489.4)
NAN = math.nan
STREAM_HZ = 20


class Flight:
    """Flies: commands and a stream of setpoints go in, states and texts come out."""

    def __init__(self) -> None:
        self.airframe = load_airframe("x500")
        self._client = pybullet.connect(pybullet.DIRECT)
        pybullet.setGravity(0.0, 0.0, -GRAVITY_M_S2, physicsClientId=self._client)
        pybullet.setTimeStep(TICK_US / 1e6, physicsClientId=self._client)
        ground = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=self._client)
        pybullet.createMultiBody(baseCollisionShapeIndex=ground, physicsClientId=self._client)
        half_height = self.airframe.collision_box_m[2] / 2
        self.body = QuadrotorBody(
            self._client, self.airframe, position_ned=(0.0, 0.0, -half_height)
        )
        self.parameters = Parameters(self.airframe.parameters)
        self.autopilot = Autopilot(
            self.parameters,
            rotor_positions_frd_m=self.airframe.rotors.positions_frd_m,
            rotor_yaw_moments_m=self.airframe.rotors.yaw_moments_m,
            hover_thrust=self.airframe.hover_thrust,
            home=HOME,
        )
        self.time_us = 0
        self.stream: OffboardSetpoint | None = None  # sent at 20 Hz while it is not None
        self.change: Callable[[Estimate], Estimate] = lambda estimate: estimate  # of each tick
        self.texts: list[tuple[int, StatusText]] = []
        self._estimator = PerfectEstimator()
        self._schedule = Schedule(STREAM_HZ)
        self.estimate: Estimate = self._estimator.update(self.body.state(0))

    def close(self) -> None:
        pybullet.disconnect(self._client)

    def place(self, position_ned: Vector3, yaw_rad: float = 0.0) -> None:
        """Start hovering in the air, in OFFBOARD."""
        self.body.reset(
            position_ned=position_ned,
            velocity_ned=(0.0, 0.0, 0.0),
            q_ned_frd=quaternion_from_euler(0.0, 0.0, yaw_rad),
            thrust=self.airframe.hover_thrust,
        )
        self._estimator = PerfectEstimator(aligned=True)
        self.estimate = self._estimator.update(self.body.state(self.time_us))
        self.autopilot.start_airborne()

    def send(self, **setpoint: Vector3 | float) -> None:
        """Stream a setpoint from now on."""
        self.stream = OffboardSetpoint(time_us=self.time_us, **setpoint)  # type: ignore[arg-type]

    def step(self) -> None:
        if self._schedule.due(self.time_us) and self.stream is not None:
            stream = self.stream
            self.autopilot.offboard_setpoint(
                OffboardSetpoint(
                    time_us=self.time_us,
                    position_ned=stream.position_ned,
                    velocity_ned=stream.velocity_ned,
                    acceleration_ned=stream.acceleration_ned,
                    yaw_rad=stream.yaw_rad,
                    yaw_rate_rad_s=stream.yaw_rate_rad_s,
                )
            )
        motors = self.autopilot.step(self.estimate)
        self.body.apply(motors, TICK_US / 1e6)
        pybullet.stepSimulation(physicsClientId=self._client)
        self.time_us += TICK_US
        self.estimate = self.change(self._estimator.update(self.body.state(self.time_us)))
        self.texts += [(self.time_us, text) for text in self.autopilot.drain_texts()]

    def run(self, seconds: float) -> None:
        end_us = self.time_us + round(seconds * 1e6)
        while self.time_us < end_us:
            self.step()

    def run_until(self, true: Callable[[], bool], *, timeout_s: float) -> float:
        """Fly until something is true; the time that it took, s."""
        start_us = self.time_us
        while not true():
            assert self.time_us - start_us < timeout_s * 1e6, "it did not happen in time"
            self.step()
        return (self.time_us - start_us) / 1e6

    def command(self, command: int, *params: float, frame: int = 0) -> int | None:
        """Send a command, NaN for what is not given; the result."""
        a, b, c, d, e, f, g = (*params, *[NAN] * (7 - len(params)))
        answer = self.autopilot.command(
            Command(command=command, params=(a, b, c, d, e, f, g), frame=frame)
        )
        return None if answer is None else answer.result

    def take_off(self, altitude_m: float = NAN) -> None:
        """Arm, take off to an altitude above home, and settle."""
        self.run(1.1)
        assert self.command(400, 1.0) == 0
        assert self.command(22, NAN, NAN, NAN, NAN, NAN, NAN, HOME[2] + altitude_m) == 0
        self.run(14.0)

    @property
    def height_m(self) -> float:
        return -self.estimate.position_ned[2]

    @property
    def said(self) -> list[str]:
        """Severity and text of each line, as `6:Takeoff detected`; their tabs are checked."""
        assert all(text.text.endswith("\t") for _, text in self.texts)
        return [f"{text.severity}:{text.text.rstrip()}" for _, text in self.texts]


@pytest.fixture
def flight() -> Iterator[Flight]:
    flight = Flight()
    yield flight
    flight.close()


@pytest.fixture
def make_flight() -> Iterator[Callable[[], Flight]]:
    flights: list[Flight] = []

    def make() -> Flight:
        flights.append(Flight())
        return flights[-1]

    yield make
    for flight in flights:
        flight.close()
