"""Fly by sticks: Altitude turns them into tilt, Position into speed, both into climb and yaw rate.

Sticks are shaped as PX4 shapes them (dead zone, then a share that is cubic), and a trajectory of
limited acceleration and jerk follows them. Centred sticks stop the vehicle, then hold its place.
"""

import math
from typing import NamedTuple, Self

from sitl.autopilot.control.low_pass import low_pass_gain
from sitl.autopilot.control.setpoint import Setpoint
from sitl.autopilot.control.trajectory import Agility, Axis, Trajectory
from sitl.autopilot.parameters import ParameterValues
from sitl.clock import TICK_S, TICK_US
from sitl.frames import GRAVITY_M_S2, wrap_pi, yaw_of
from sitl.records.modes import Mode
from sitl.records.motion import Vector3
from sitl.records.sensing import Estimate
from sitl.records.vehicle import Sticks

NAN = math.nan
ORIGIN: Vector3 = (0.0, 0.0, 0.0)
CENTRED = Sticks(time_us=0, forward=0.0, right=0.0, up=0.0, turn=0.0)
CLIMB_STICK = 0.1  # assumption: more than this takes off
RESTING_RAD_S = 1e-3  # a turn slower than this is over


class ManualParameters(NamedTuple):
    """How sticks are shaped, and how fast and briskly the vehicle follows them."""

    dead_zone: float  # of the sticks, MPC_HOLD_DZ
    expo_xy: float  # the share that is cubic, MPC_XY_MAN_EXPO
    expo_z: float  # MPC_Z_MAN_EXPO
    expo_yaw: float  # MPC_YAW_EXPO
    speed_m_s: float  # MPC_VEL_MANUAL, within MPC_XY_VEL_MAX
    speed_up_m_s: float  # MPC_Z_VEL_MAX_UP
    speed_down_m_s: float  # MPC_Z_VEL_MAX_DN
    tilt_max_rad: float  # MPC_MAN_TILT_MAX
    yaw_rate_max_rad_s: float  # MPC_MAN_Y_MAX
    yaw_rate_gain: float  # of the low pass, MPC_MAN_Y_TAU
    agility_xy: Agility  # MPC_ACC_HOR, MPC_JERK_MAX
    agility_z: Agility  # the smaller of MPC_ACC_UP_MAX and MPC_ACC_DOWN_MAX, MPC_JERK_MAX
    hold_speed_xy_m_s: float  # slower than this, the place is held, MPC_HOLD_MAX_XY
    hold_speed_z_m_s: float  # MPC_HOLD_MAX_Z

    @classmethod
    def resolve(cls, values: ParameterValues) -> Self:
        """Take PX4's values, in SI units."""
        tau_s, jerk = values["MPC_MAN_Y_TAU"], values["MPC_JERK_MAX"]
        acceleration_z = min(values["MPC_ACC_UP_MAX"], values["MPC_ACC_DOWN_MAX"])
        return cls(
            dead_zone=values["MPC_HOLD_DZ"],
            expo_xy=values["MPC_XY_MAN_EXPO"],
            expo_z=values["MPC_Z_MAN_EXPO"],
            expo_yaw=values["MPC_YAW_EXPO"],
            speed_m_s=min(values["MPC_VEL_MANUAL"], values["MPC_XY_VEL_MAX"]),
            speed_up_m_s=values["MPC_Z_VEL_MAX_UP"],
            speed_down_m_s=values["MPC_Z_VEL_MAX_DN"],
            tilt_max_rad=math.radians(values["MPC_MAN_TILT_MAX"]),
            yaw_rate_max_rad_s=math.radians(values["MPC_MAN_Y_MAX"]),
            yaw_rate_gain=low_pass_gain(1.0 / (2.0 * math.pi * tau_s)) if tau_s > 0.0 else 1.0,
            agility_xy=Agility(values["MPC_ACC_HOR"], jerk),
            agility_z=Agility(acceleration_z, jerk),
            hold_speed_xy_m_s=values["MPC_HOLD_MAX_XY"],
            hold_speed_z_m_s=values["MPC_HOLD_MAX_Z"],
        )


class ManualState(NamedTuple):
    """What is held, and how the vehicle turns."""

    holds_xy: bool = False
    holds_z: bool = False
    yaw_rad: float = 0.0
    yaw_rate_rad_s: float = 0.0
    moved_us: int = -1  # when the sticks last led the vehicle


class Manual:
    """Keeps the sticks, and the trajectory that they lead."""

    def __init__(self, parameters: ManualParameters) -> None:
        self.parameters = parameters
        self._sticks = CENTRED
        self._trajectory = Trajectory(ORIGIN, ORIGIN, ORIGIN)
        self._state = ManualState()

    def receive(self, sticks: Sticks) -> None:
        """Take the sticks' newest positions."""
        self._sticks = sticks

    @property
    def wants_climb(self) -> bool:
        """Whether the sticks request that a vehicle on the ground take off."""
        return self._sticks.up > CLIMB_STICK

    def wait(self, estimate: Estimate) -> Setpoint:
        """Stay over the place while the rotors take the weight; only the climb rate counts."""
        self._state = self._start(estimate)
        return Setpoint(velocity_ned=(0.0, 0.0, self._climb()), yaw_rad=self._state.yaw_rad)

    def advance(self, mode: Mode, estimate: Estimate) -> Setpoint:
        """Move by one tick and give the setpoint of ALTCTL or POSCTL."""
        before, time_us = self._state, estimate.time_us
        if time_us - before.moved_us != TICK_US:
            before = self._start(estimate)
        yaw, yaw_rate = self._turn(before, estimate)
        holds_z = self._lead_z(estimate, held=before.holds_z)
        trajectory = self._trajectory
        down = trajectory.down
        z = down.position if holds_z else NAN
        if mode is Mode.ALTCTL or not estimate.position_valid:
            self._state = ManualState(before.holds_xy, holds_z, yaw, yaw_rate, time_us)
            ax, ay = self._tilt(yaw)
            velocity, acceleration = (NAN, NAN, down.velocity), (ax, ay, down.acceleration)
            return Setpoint((NAN, NAN, z), velocity, acceleration, yaw, yaw_rate)
        holds_xy = self._lead_xy(estimate, yaw, held=before.holds_xy)
        self._state = ManualState(holds_xy, holds_z, yaw, yaw_rate, time_us)
        x = trajectory.north.position if holds_xy else NAN
        y = trajectory.east.position if holds_xy else NAN
        return Setpoint((x, y, z), trajectory.velocity, trajectory.acceleration, yaw, yaw_rate)

    def _start(self, estimate: Estimate) -> ManualState:
        """Begin out of the vehicle's own motion."""
        self._trajectory = Trajectory(estimate.position_ned, estimate.velocity_ned, ORIGIN)
        return ManualState(yaw_rad=yaw_of(estimate.q_ned_frd))

    def _climb(self) -> float:
        """Velocity down that the throttle stick requests."""
        parameters = self.parameters
        up = self._shape(self._sticks.up, parameters.expo_z)
        return -up * (parameters.speed_up_m_s if up > 0.0 else parameters.speed_down_m_s)

    def _horizontal(self) -> tuple[float, float]:
        """Forward and right, shaped, within the unit circle."""
        forward = self._shape(self._sticks.forward, self.parameters.expo_xy)
        right = self._shape(self._sticks.right, self.parameters.expo_xy)
        norm = math.hypot(forward, right)
        return (forward / norm, right / norm) if norm > 1.0 else (forward, right)

    def _turn(self, before: ManualState, estimate: Estimate) -> tuple[float, float]:
        """Give the heading, and its rate."""
        parameters, rate = self.parameters, before.yaw_rate_rad_s
        requested = self._shape(self._sticks.turn, parameters.expo_yaw)
        requested *= parameters.yaw_rate_max_rad_s
        rate += parameters.yaw_rate_gain * (requested - rate)
        if requested == 0.0 and abs(rate) < RESTING_RAD_S:
            return before.yaw_rad, 0.0
        # While it turns, the heading is where the vehicle has come to.
        return wrap_pi(yaw_of(estimate.q_ned_frd) + rate * TICK_S), rate

    def _tilt(self, yaw_rad: float) -> tuple[float, float]:
        """Horizontal acceleration, NED, of the tilt that the sticks request."""
        forward, right = self._horizontal()
        share = math.hypot(forward, right)
        if share == 0.0:
            return 0.0, 0.0
        size = GRAVITY_M_S2 * math.tan(share * self.parameters.tilt_max_rad) / share
        return _rotate(forward * size, right * size, yaw_rad)

    def _lead_z(self, estimate: Estimate, *, held: bool) -> bool:
        """Move up or down, and say whether the height is held."""
        axis, climb, parameters = self._trajectory.down, self._climb(), self.parameters
        axis.lead(climb, parameters.agility_z)
        stopped = climb == 0.0 and axis.velocity == 0.0
        slow = abs(estimate.velocity_ned[2]) < parameters.hold_speed_z_m_s
        return _hold((axis,), estimate.position_ned[2:], held=held, stopped=stopped, slow=slow)

    def _lead_xy(self, estimate: Estimate, yaw_rad: float, *, held: bool) -> bool:
        """Move horizontally, and say whether the place is held."""
        parameters, north, east = self.parameters, self._trajectory.north, self._trajectory.east
        forward, right = self._horizontal()
        speed, agility = parameters.speed_m_s, parameters.agility_xy
        vx, vy = _rotate(forward * speed, right * speed, yaw_rad)
        north.lead(vx, agility)
        east.lead(vy, agility)
        stopped = vx == vy == north.velocity == east.velocity == 0.0
        slow = math.hypot(*estimate.velocity_ned[:2]) < parameters.hold_speed_xy_m_s
        place = estimate.position_ned[:2]
        return _hold((north, east), place, held=held, stopped=stopped, slow=slow)

    def _shape(self, stick: float, expo: float) -> float:
        """Dead zone, then linear and cubic in PX4's proportion."""
        size, dead_zone = abs(stick), self.parameters.dead_zone
        if size <= dead_zone:
            return 0.0
        size = min((size - dead_zone) / (1.0 - dead_zone), 1.0)
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
