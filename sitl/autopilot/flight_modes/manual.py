"""Fly by sticks: Altitude turns them into tilt, Position into speed, both into climb and yaw rate.

Sticks are shaped as PX4 shapes them (dead zone, then a share that is cubic), and a trajectory of
limited acceleration and jerk follows them. Centred sticks stop the vehicle, then hold its place.
"""

import math

from sitl.autopilot.control.low_pass import low_pass_gain
from sitl.autopilot.control.setpoint import Setpoint
from sitl.autopilot.control.trajectory import TICK_S, Agility, Axis, Trajectory
from sitl.autopilot.parameters import Parameters
from sitl.clock import TICK_US
from sitl.frames import GRAVITY_M_S2, wrap_pi, yaw_of
from sitl.records.modes import Mode
from sitl.records.motion import Vector3
from sitl.records.sensing import Estimate
from sitl.records.vehicle import Sticks

NAN = math.nan
ORIGIN: Vector3 = (0.0, 0.0, 0.0)
CENTRED = Sticks(time_us=0, forward=0.0, right=0.0, up=0.0, turn=0.0)
CLIMB_STICK = 0.1  # assumption: more than this takes off


class Manual:
    """Keeps the sticks, and the trajectory that they lead."""

    def __init__(self, parameters: Parameters) -> None:
        self._sticks = CENTRED
        self._trajectory = Trajectory(ORIGIN, ORIGIN, ORIGIN)
        self._holds_xy = self._holds_z = False
        self._yaw_rad = self._yaw_rate = 0.0
        self._moved_us = -1
        self.load(parameters)

    def load(self, parameters: Parameters) -> None:
        """Take speeds and shapes from the parameters."""
        p = parameters
        self._dead_zone = p["MPC_HOLD_DZ"]
        self._expo = (p["MPC_XY_MAN_EXPO"], p["MPC_Z_MAN_EXPO"], p["MPC_YAW_EXPO"])
        self._speed = min(p["MPC_VEL_MANUAL"], p["MPC_XY_VEL_MAX"])
        self._up, self._down = p["MPC_Z_VEL_MAX_UP"], p["MPC_Z_VEL_MAX_DN"]
        self._tilt_rad = math.radians(p["MPC_MAN_TILT_MAX"])
        self._turn_max = math.radians(p["MPC_MAN_Y_MAX"])
        tau = p["MPC_MAN_Y_TAU"]
        self._turn_gain = low_pass_gain(1.0 / (2.0 * math.pi * tau), TICK_S) if tau > 0.0 else 1.0
        self._agility_xy = Agility(p["MPC_ACC_HOR"], p["MPC_JERK_MAX"])
        self._agility_z = Agility(
            min(p["MPC_ACC_UP_MAX"], p["MPC_ACC_DOWN_MAX"]), p["MPC_JERK_MAX"]
        )
        self._hold_speeds = (p["MPC_HOLD_MAX_XY"], p["MPC_HOLD_MAX_Z"])

    def receive(self, sticks: Sticks) -> None:
        """Take the sticks' newest positions."""
        self._sticks = sticks

    @property
    def wants_climb(self) -> bool:
        """Whether the sticks ask a vehicle on the ground to take off."""
        return self._sticks.up > CLIMB_STICK

    def wait(self, estimate: Estimate) -> Setpoint:
        """Stay over the place while the rotors take the weight; only the climb rate counts."""
        self._start(estimate)
        climb = self._climb()
        return Setpoint(velocity_ned=(0.0, 0.0, climb), yaw_rad=self._yaw_rad)

    def advance(self, mode: Mode, estimate: Estimate) -> Setpoint:
        """Move by one tick and give the setpoint of ALTCTL or POSCTL."""
        if estimate.time_us - self._moved_us != TICK_US:
            self._start(estimate)
        self._moved_us = estimate.time_us
        yaw, yaw_rate = self._turn(estimate)
        z, vz, az = self._lead_z(estimate)
        if mode is Mode.ALTCTL or not estimate.position_valid:
            ax, ay = self._tilt(yaw)
            return Setpoint((NAN, NAN, z), (NAN, NAN, vz), (ax, ay, az), yaw, yaw_rate)
        (x, y), (vx, vy), (ax, ay) = self._lead_xy(estimate, yaw)
        return Setpoint((x, y, z), (vx, vy, vz), (ax, ay, az), yaw, yaw_rate)

    def _start(self, estimate: Estimate) -> None:
        self._trajectory = Trajectory(estimate.position_ned, estimate.velocity_ned, ORIGIN)
        self._holds_xy = self._holds_z = False
        self._yaw_rad, self._yaw_rate = yaw_of(estimate.q_ned_frd), 0.0

    def _climb(self) -> float:
        """Velocity down that the throttle stick asks for."""
        up = self._shape(self._sticks.up, self._expo[1])
        return -up * (self._up if up > 0.0 else self._down)

    def _horizontal(self) -> tuple[float, float]:
        """Forward and right, shaped, within the unit circle."""
        forward = self._shape(self._sticks.forward, self._expo[0])
        right = self._shape(self._sticks.right, self._expo[0])
        norm = math.hypot(forward, right)
        return (forward / norm, right / norm) if norm > 1.0 else (forward, right)

    def _turn(self, estimate: Estimate) -> tuple[float, float]:
        wanted = self._shape(self._sticks.turn, self._expo[2]) * self._turn_max
        self._yaw_rate += self._turn_gain * (wanted - self._yaw_rate)
        if wanted == 0.0 and abs(self._yaw_rate) < 1e-3:
            self._yaw_rate = 0.0
        else:  # while it turns, the heading is where the vehicle has come to
            self._yaw_rad = wrap_pi(yaw_of(estimate.q_ned_frd) + self._yaw_rate * TICK_S)
        return self._yaw_rad, self._yaw_rate

    def _tilt(self, yaw_rad: float) -> tuple[float, float]:
        """Horizontal acceleration, NED, of the tilt that the sticks ask for."""
        forward, right = self._horizontal()
        share = math.hypot(forward, right)
        if share == 0.0:
            return 0.0, 0.0
        size = GRAVITY_M_S2 * math.tan(share * self._tilt_rad) / share
        return _rotate(forward * size, right * size, yaw_rad)

    def _lead_z(self, estimate: Estimate) -> Vector3:
        axis, climb = self._trajectory.down, self._climb()
        axis.lead(climb, self._agility_z)
        stopped = climb == 0.0 and axis.velocity == 0.0
        slow = abs(estimate.velocity_ned[2]) < self._hold_speeds[1]
        self._holds_z = _hold(
            (axis,), estimate.position_ned[2:], held=self._holds_z, stopped=stopped, slow=slow
        )
        return (axis.position if self._holds_z else NAN), axis.velocity, axis.acceleration

    def _lead_xy(
        self, estimate: Estimate, yaw_rad: float
    ) -> tuple[tuple[float, float], tuple[float, float], tuple[float, float]]:
        north, east = self._trajectory.north, self._trajectory.east
        forward, right = self._horizontal()
        vx, vy = _rotate(forward * self._speed, right * self._speed, yaw_rad)
        north.lead(vx, self._agility_xy)
        east.lead(vy, self._agility_xy)
        stopped = vx == vy == north.velocity == east.velocity == 0.0
        slow = math.hypot(*estimate.velocity_ned[:2]) < self._hold_speeds[0]
        self._holds_xy = _hold(
            (north, east),
            estimate.position_ned[:2],
            held=self._holds_xy,
            stopped=stopped,
            slow=slow,
        )
        place = (north.position, east.position) if self._holds_xy else (NAN, NAN)
        return (
            place,
            (north.velocity, east.velocity),
            (north.acceleration, east.acceleration),
        )

    def _shape(self, stick: float, expo: float) -> float:
        """Dead zone, then linear and cubic in PX4's proportion."""
        size = abs(stick)
        if size <= self._dead_zone:
            return 0.0
        size = min((size - self._dead_zone) / (1.0 - self._dead_zone), 1.0)
        return math.copysign((1.0 - expo) * size + expo * size**3, stick)


def _hold(
    axes: tuple[Axis, ...], place: tuple[float, ...], *, held: bool, stopped: bool, slow: bool
) -> bool:
    """Say whether a place is held; where that begins, it is the vehicle's own."""
    if stopped and slow and not held:
        for axis, position in zip(axes, place, strict=True):
            axis.position = position
    return stopped and (held or slow)


def _rotate(forward: float, right: float, yaw_rad: float) -> tuple[float, float]:
    cos, sin = math.cos(yaw_rad), math.sin(yaw_rad)
    return cos * forward - sin * right, sin * forward + cos * right
