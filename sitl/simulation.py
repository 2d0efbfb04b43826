"""One vehicle, one course, one clock: a tick at a time, in process, without sockets.

A tick: the autopilot looks at the last estimate and drives the motors, the world moves by 4 ms,
the referee judges the movement, the estimator senses it. Images are taken only when asked for.
"""

import math
from dataclasses import dataclass

import numpy as np

from sitl.autopilot.autopilot import Autopilot
from sitl.autopilot.parameters import Parameters
from sitl.clock import TICK_US, Schedule
from sitl.frames import quaternion_from_euler
from sitl.records.conditions import Conditions
from sitl.records.course import CourseEvent, CourseStatus
from sitl.records.failures import SENSORS, Failure, FailureType, FailureUnit
from sitl.records.images import Image, ImageStamp
from sitl.records.motion import Vector3, VehicleState
from sitl.records.sensing import Estimate, Readings
from sitl.sensors.battery import Pack
from sitl.sensors.breakage import Breakage
from sitl.sensors.camera.camera import Camera
from sitl.sensors.camera.look import Look, at_dusk, draw_look, in_fog
from sitl.sensors.camera.shutter import Delay, Spoiler
from sitl.sensors.estimate.estimator import SETTLED_S, Estimator, PerfectEstimator
from sitl.sensors.noise import normals
from sitl.sensors.suite import Sensors
from sitl.world.airframe import load_airframe
from sitl.world.referee import Referee
from sitl.world.track import Direction, Track, make_track, with_decoys
from sitl.world.wind import blow
from sitl.world.world import World

CAMERA_RATE_HZ = 20
LATE_S = 0.5  # by how much a camera is late that an injected failure delays
HOME = (47.397742, 8.545594, 489.4)  # deg, deg, m AMSL; PX4's default
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


class Simulation:
    """The vehicle in its world; its autopilot and course are public, for whoever talks to them."""

    def __init__(self, config: SimulationConfig) -> None:
        """Build the world at time 0, the vehicle on the ground at the spawn point.

        Raises:
            UsageError: the track's noise or the airframe cannot be.

        """
        self.config = config
        self.track = _lay_out(config)
        airframe = load_airframe(config.airframe)
        self.parameters = Parameters(airframe.parameters)
        self.autopilot = Autopilot(
            self.parameters,
            rotor_positions_frd_m=airframe.rotor_positions_frd_m,
            rotor_yaw_moments_m=airframe.rotor_yaw_moments_m,
            hover_thrust=airframe.hover_thrust,
            home=config.home,
        )
        standing = self.track.gates + self.track.decoys
        self._world = World(standing, airframe, tick_s=TICK_US / 1e6, gui=config.gui)
        first = config.first_gate
        self.course_gates = self.track.gates[first:] + self.track.gates[:first]
        self._referee = Referee(self.course_gates, config.laps)
        self._sensors = Sensors([config.seed, SENSOR_STREAM], altitude_m=config.home[2])
        self._estimator = self._make_estimator()
        self._breakage = Breakage(np.random.default_rng([config.seed, BREAKAGE_STREAM]))
        self._camera = Camera(standing, _draw_look(config))
        self._delay: Delay | None = None
        self._latency_s = 0.0
        self._take_conditions()
        self._images = Schedule(CAMERA_RATE_HZ)
        self._sequence = 0
        self._events: list[CourseEvent] = []
        self._hover_thrust = airframe.hover_thrust
        self.time_us = 0
        self.state: VehicleState = self._world.body.state(0)
        self._load()
        self.readings: Readings = self._sensors.update(self.state, self._pack)
        self.estimate: Estimate = self._estimator.update(self.state, self.readings)

    def close(self) -> None:
        """Free the physics engine and the renderer."""
        self._camera.close()
        self._world.close()

    def step(self) -> None:
        """Advance by one tick."""
        motors = self._breakage.drive(self.autopilot.step(self.estimate), self.time_us)
        for failure in self.autopilot.drain_failures():
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

    @property
    def course(self) -> CourseStatus:
        """The score so far."""
        return self._referee.status

    def drain_course_events(self) -> list[CourseEvent]:
        """Hand over what the referee saw since the last call."""
        events, self._events = self._events, []
        return events

    def image_due(self) -> bool:
        """Whether the camera gives an image out at this tick; true once for each."""
        is_taken = self._images.due(self.time_us) and self._breakage.takes_image(self.time_us)
        if self._delay is None:
            return is_taken
        if is_taken:
            self._delay.put(self._take_image())
        return self._delay.is_due(self.time_us)

    @property
    def is_silent(self) -> bool:
        """Whether a failure keeps the vehicle from sending and hearing anything."""
        return self._breakage.is_silent(self.time_us)

    @property
    def signal_fault(self) -> FailureType:
        """What a failure does to the signal."""
        return self._breakage.signal_fault

    @property
    def image_stamp(self) -> ImageStamp:
        """Time and number of the image that `render` gives."""
        if self._delay is None:
            return ImageStamp(self.time_us, self._sequence)
        return self._delay.first_stamp

    def render(self) -> Image:
        """Give the image out that is due: one of this moment, unless the camera is late."""
        return self._take_image() if self._delay is None else self._delay.take()

    def _take_image(self) -> Image:
        rgb = self._camera.render(self.state.position_ned, self.state.q_ned_frd)
        if self._spoiler is not None:
            rgb = self._spoiler.spoil(rgb)
        image = Image(time_us=self.time_us, sequence=self._sequence, rgb=rgb)
        self._sequence += 1
        return self._breakage.picture(image)

    def start_airborne(self, position_ned: Vector3, yaw_rad: float, speed_m_s: float = 0.0) -> None:
        """Put the vehicle into the air: armed, in OFFBOARD, flying straight ahead."""
        velocity = (speed_m_s * math.cos(yaw_rad), speed_m_s * math.sin(yaw_rad), 0.0)
        self._world.body.reset(
            position_ned=position_ned,
            velocity_ned=velocity,
            q_ned_frd=quaternion_from_euler(0.0, 0.0, yaw_rad),
            thrust=self._hover_thrust,
        )
        self.state = self._world.body.state(self.time_us)
        self._estimator.align()
        self._sense()
        self.autopilot.start_airborne()

    def _fail(self, failure: Failure) -> None:
        if failure.unit in SENSORS or failure.unit is FailureUnit.BATTERY:
            self._sensors.fail(failure.unit, failure.type, self.time_us)
        else:
            self._breakage.fail(failure, self.time_us)
        if failure.unit is FailureUnit.CAMERA:
            self._delay = self._make_delay(is_late=failure.type is FailureType.DELAYED)

    def _make_delay(self, *, is_late: bool) -> Delay | None:
        """Give what delays the camera's images; what is under way stays so."""
        latency_s = self.config.conditions.camera.latency_s + (LATE_S if is_late else 0.0)
        if latency_s == self._latency_s:
            return self._delay
        self._latency_s = latency_s
        return Delay(latency_s) if latency_s > 0.0 else None

    def _sense(self) -> None:
        if self.parameters.values is not self._parameter_values:
            self._load()
        self._sensors.battery.advance(TICK_US, self._pack, armed=self.autopilot.armed)
        self.readings = self._sensors.update(self.state, self._pack, shaken=self.autopilot.armed)
        self.estimate = self._estimator.update(self.state, self.readings)

    def _load(self) -> None:
        """Take changed parameters in."""
        p = self._parameter_values = self.parameters.values
        self._pack = Pack(
            int(p["BAT1_N_CELLS"]),
            p["BAT1_V_CHARGED"],
            p["BAT1_V_EMPTY"],
            p["SIM_BAT_DRAIN"],
            p["SIM_BAT_MIN_PCT"] / 100.0,
        )

    def _take_conditions(self) -> None:
        """Set up wind and camera faults; None where the conditions ask for nothing."""
        conditions, seed = self.config.conditions, self.config.seed
        self._wind = self._spoiler = None
        if conditions.wind != CLEAR_DAY.wind:
            noise = normals(np.random.default_rng([seed, WIND_STREAM]))
            self._wind = blow(conditions.wind, noise, TICK_US / 1e6)
        if conditions.camera != CLEAR_DAY.camera:
            rng = np.random.default_rng([seed, SPOILER_STREAM])
            self._spoiler = Spoiler(conditions.camera, rng)
        self._delay = self._make_delay(is_late=False)

    def _make_estimator(self) -> Estimator | PerfectEstimator:
        if self.config.perfect_estimate:
            return PerfectEstimator(settled_s=self.config.settled_s)
        imu = self._sensors.imu
        rng = np.random.default_rng([self.config.seed, ESTIMATE_STREAM])
        return Estimator(
            rng,
            imu.gyro_bias_frd,
            imu.accelerometer_bias_frd,
            rotor_noise_share=self.config.conditions.estimate.rotor_noise_share,
            settled_s=self.config.settled_s,
        )


def _lay_out(config: SimulationConfig) -> Track:
    radius_noise_m, height_noise_m = config.noise_m
    track = make_track(
        config.track_seed,
        radius_noise_m=radius_noise_m,
        height_noise_m=height_noise_m,
        direction=config.direction,
    )
    inwards_m = config.conditions.course.decoy_inwards_m
    return track if inwards_m == 0.0 else with_decoys(track, inwards_m)


def _draw_look(config: SimulationConfig) -> Look:
    light = config.conditions.light
    look = draw_look(np.random.default_rng([config.seed, LOOK_STREAM]))
    if light.daylight_share < 1.0:
        look = at_dusk(look, light.daylight_share)
    return in_fog(look, light.fog_visibility_m)
