"""One vehicle, one course, one clock: a tick at a time, whoever flies; without sockets of its own.

A tick: the flight controller drives the motors, the world moves by 4 ms, the referee judges the
movement, the sensors read, and the controller hears of it. Images are taken only when asked for.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Generic, TypeVar

import numpy as np

from sitl.clock import TICK_S, TICK_US
from sitl.flight_controller import FlightController
from sitl.frames import HOME
from sitl.records.conditions import Conditions, Wind
from sitl.records.course import CourseEvent, CourseStatus, Direction
from sitl.records.failures import SENSORS, Failure, FailureType, FailureUnit
from sitl.records.images import Image, ImageStamp
from sitl.records.motion import Quaternion, Vector3, VehicleState
from sitl.records.sensing import Readings
from sitl.sensors.breakage import Breakage
from sitl.sensors.camera.camera import Camera
from sitl.sensors.camera.feed import CameraFeed
from sitl.sensors.camera.look import Look, at_dusk, draw_look, in_fog
from sitl.sensors.estimate.estimator import SETTLED_S
from sitl.sensors.imu import Imu
from sitl.sensors.noise import normals
from sitl.sensors.suite import Sensors
from sitl.world.airframe import Airframe, load_airframe
from sitl.world.referee import Referee
from sitl.world.track import Track, make_track, with_decoys
from sitl.world.wind import blow
from sitl.world.world import World

# These separate the uses of the vehicle's seed from each other.
LOOK_STREAM, SENSOR_STREAM, ESTIMATE_STREAM, BREAKAGE_STREAM = 0x100C, 0x5E45, 0xE571, 0xB4EA
WIND_STREAM, SPOILER_STREAM = 0xA114, 0x5B01
CLEAR_DAY = Conditions()


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulationConfig:
    """All that a flight depends on, apart from what is sent to the vehicle."""

    seed: int = 0  # of the vehicle and the day: look, sensor noise, the estimate's errors
    track_seed: int = 0
    noise_m: tuple[float, float] = (1.0, 2.0)  # GRN, GHN: gate radius and height
    direction: Direction = "cw"
    laps: int = 1
    first_gate: int = 0  # the gate that is due first
    home: Vector3 = HOME
    airframe: str = "x500"
    perfect_estimate: bool = False  # the autopilot knows the truth
    settled_s: float = SETTLED_S  # after boot, when it may be armed
    conditions: Conditions = CLEAR_DAY
    gui: bool = False


Controller = TypeVar("Controller", bound=FlightController)


class FlownVehicle(Generic[Controller]):
    """The vehicle's body in its world, with sensors, camera and referee, flown by a controller."""

    def __init__(
        self,
        config: SimulationConfig,
        make_controller: Callable[[Airframe, Imu], Controller],
        *,
        imu_noise_share: float = 1.0,
    ) -> None:
        """Build the world at time 0, the vehicle on the ground at the spawn point.

        `imu_noise_share` is how much of the turning rotors' noise the inertial unit reads.

        Raises:
            UsageError: the track's noise or the airframe cannot be.

        """
        self.config = config
        self.time_us = 0
        self.track = lay_out(config)
        airframe = self.airframe = load_airframe(config.airframe)
        breakage_rng = chance(config, BREAKAGE_STREAM)
        self._breakage = Breakage(breakage_rng)
        self._wind = _make_wind(config)
        standing = self.track.gates + self.track.decoys
        self._world = World(standing, airframe, tick_s=TICK_S, gui=config.gui)
        first = config.first_gate
        self.course_gates = self.track.gates[first:] + self.track.gates[:first]
        self._referee = Referee(self.course_gates, config.laps)
        self._events: list[CourseEvent] = []
        self._sensors = Sensors(
            [config.seed, SENSOR_STREAM],
            altitude_m=config.home[2],
            rotor_noise_share=imu_noise_share,
        )
        camera = Camera(
            standing,
            look_of_day(config),
            field_of_view_deg=config.conditions.scenery.field_of_view_deg,
        )
        self._camera = feed_of_day(config, camera, failure_rng=breakage_rng)
        controller = self.controller = make_controller(airframe, self._sensors.imu)
        self.state: VehicleState = self._world.body.state(0)
        self.readings: Readings = self._sensors.update(self.state, controller.pack)
        controller.sense(self.state, self.readings)

    def close(self) -> None:
        """Free the physics engine and the renderer."""
        self._camera.close()
        self._world.close()

    def step(self) -> None:
        """Advance by one tick."""
        controller = self.controller
        motors = self._breakage.drive(controller.drive(), self.time_us)
        for failure in controller.drain_failures():
            self._fail(failure)
        if self._wind is not None:
            self._world.body.wind_ned = next(self._wind)
        previous = self.state
        self.time_us += TICK_US
        self.state = self._world.step(motors, self.time_us)
        self._events += self._referee.update(
            previous.position_ned, self.state.position_ned, contact=self._world.touches_gate()
        )
        self._sense()

    def _put(self, position_ned: Vector3, velocity_ned: Vector3, q_ned_frd: Quaternion) -> None:
        """Put the body there, with the thrust of a hover; to be sensed after it."""
        self._world.body.reset(
            position_ned=position_ned,
            velocity_ned=velocity_ned,
            q_ned_frd=q_ned_frd,
            thrust=self.airframe.hover_thrust,
        )
        self.state = self._world.body.state(self.time_us)

    def _sense(self) -> None:
        controller = self.controller
        armed, pack = controller.armed, controller.pack
        self._sensors.battery.advance(TICK_US, pack, armed=armed)
        self.readings = self._sensors.update(self.state, pack, shaken=armed)
        controller.sense(self.state, self.readings)

    def image_due(self) -> bool:
        """Whether the camera gives an image out at this tick; true once for each."""
        return self._camera.is_due(self.state)

    @property
    def image_stamp(self) -> ImageStamp:
        """Time and number of the image that `render` gives."""
        return self._camera.stamp(self.time_us)

    def render(self) -> Image:
        """Give the image out that is due: one of this moment, unless the camera is late."""
        return self._camera.give(self.state)

    @property
    def course(self) -> CourseStatus:
        """The score so far."""
        return self._referee.status

    def drain_course_events(self) -> list[CourseEvent]:
        """Hand over what the referee saw since the last call."""
        events, self._events = self._events, []
        return events

    @property
    def is_silent(self) -> bool:
        """Whether a failure keeps the vehicle from sending and hearing anything."""
        return self._breakage.is_silent(self.time_us)

    @property
    def signal_fault(self) -> FailureType:
        """What a failure does to the signal."""
        return self._breakage.signal_fault

    def _fail(self, failure: Failure) -> None:
        if failure.unit in SENSORS or failure.unit is FailureUnit.BATTERY:
            self._sensors.fail(failure.unit, failure.type, self.time_us)
        elif failure.unit is FailureUnit.CAMERA:
            self._camera.fail(failure.type, self.time_us)
        else:
            self._breakage.fail(failure, self.time_us)


def look_of_day(config: SimulationConfig) -> Look:
    """Draw what the world looks like on the day of a flight."""
    light = config.conditions.light
    look = draw_look(chance(config, LOOK_STREAM), config.conditions.scenery)
    if light.daylight_share < 1.0:
        look = at_dusk(look, light.daylight_share)
    return in_fog(look, light.fog_visibility_m)


def feed_of_day(
    config: SimulationConfig, camera: Camera, *, failure_rng: np.random.Generator
) -> CameraFeed:
    """Let a camera give images as it does on the day of a flight, from its first one on."""
    return CameraFeed(
        camera,
        config.conditions.camera,
        fault_rng=chance(config, SPOILER_STREAM),
        failure_rng=failure_rng,
    )


def chance(config: SimulationConfig, stream: int) -> np.random.Generator:
    """Make the generator of one use of the vehicle's seed."""
    return np.random.default_rng([config.seed, stream])


def lay_out(config: SimulationConfig) -> Track:
    """Put the gates of a flight's course, and those beside it, into the world."""
    radius_noise_m, height_noise_m = config.noise_m
    track = make_track(
        config.track_seed,
        radius_noise_m=radius_noise_m,
        height_noise_m=height_noise_m,
        direction=config.direction,
    )
    shape = config.conditions.scenery.gate
    track = replace(track, gates=tuple(replace(gate, shape=shape) for gate in track.gates))
    inwards_m = config.conditions.course.decoy_inwards_m
    return track if inwards_m == 0.0 else with_decoys(track, inwards_m)


def _make_wind(config: SimulationConfig) -> Iterator[Vector3] | None:
    """Let the wind blow; None where the air stands still."""
    if config.conditions.wind == Wind():
        return None
    return blow(config.conditions.wind, normals(chance(config, WIND_STREAM)), TICK_S)
