"""The automatic modes: take off, hold, return, land; a mode becomes a setpoint a tick.

Every mode moves one `Trajectory`, which starts from the vehicle's own motion when the mode begins.
"""

import math
from math import isnan
from typing import NamedTuple, Self

from sitl.autopilot.control.heading import Heading, HeadingParameters
from sitl.autopilot.control.setpoint import Setpoint
from sitl.autopilot.control.trajectory import Agility, Trajectory
from sitl.autopilot.flight_modes.mission import NOWHERE, Leg, MissionFlight
from sitl.autopilot.flight_modes.return_home import ReturnHome, ReturnParameters, ReturnPhase
from sitl.autopilot.parameters import ParameterValues
from sitl.frames import yaw_of
from sitl.records.modes import Mode
from sitl.records.motion import Vector3
from sitl.records.sensing import Estimate

NAN = math.nan
ORIGIN: Vector3 = (0.0, 0.0, 0.0)
TAKEOFF_SHARE = 0.5  # of NAV_MC_ALT_RAD: PX4 was seen to hold from 2.1 m on, of 2.5 m
STOPPED_M_S = 0.2  # slower than this, the place is held
HEADING_RADIUS_M = 2.0  # closer to the goal than this, the heading stays


class Goal(NamedTuple):
    """Where a mode is to lead, local NED; NaN where it stays as it is."""

    position_ned: Vector3 = (NAN, NAN, NAN)  # m
    yaw_rad: float = NAN
    speed_m_s: float = NAN  # horizontal


class NavigatorParameters(NamedTuple):
    """Speeds and limits of the automatic modes."""

    speed_max_m_s: float  # MPC_XY_VEL_MAX
    cruise_m_s: float  # MPC_XY_CRUISE, within that
    up_m_s: float  # MPC_Z_V_AUTO_UP
    down_m_s: float  # MPC_Z_V_AUTO_DN
    takeoff_m_s: float  # MPC_TKO_SPEED
    landing_m_s: float  # MPC_LAND_SPEED
    slow_below_m: float  # MPC_LAND_ALT2: descends at landing_m_s
    fast_above_m: float  # MPC_LAND_ALT1: descends at down_m_s
    agility_xy: Agility  # MPC_ACC_HOR, MPC_JERK_AUTO
    agility_z: Agility  # MPC_ACC_UP_MAX, MPC_ACC_DOWN_MAX, MPC_JERK_AUTO
    altitude_radius_m: float  # NAV_MC_ALT_RAD
    heading: HeadingParameters
    return_home: ReturnParameters

    @classmethod
    def resolve(cls, values: ParameterValues) -> Self:
        """Take PX4's values, in SI units."""
        jerk, acceleration_up = values["MPC_JERK_AUTO"], values["MPC_ACC_UP_MAX"]
        return cls(
            speed_max_m_s=values["MPC_XY_VEL_MAX"],
            cruise_m_s=min(values["MPC_XY_CRUISE"], values["MPC_XY_VEL_MAX"]),
            up_m_s=values["MPC_Z_V_AUTO_UP"],
            down_m_s=values["MPC_Z_V_AUTO_DN"],
            takeoff_m_s=values["MPC_TKO_SPEED"],
            landing_m_s=values["MPC_LAND_SPEED"],
            slow_below_m=values["MPC_LAND_ALT2"],
            fast_above_m=values["MPC_LAND_ALT1"],
            agility_xy=Agility(values["MPC_ACC_HOR"], jerk),
            agility_z=Agility(min(acceleration_up, values["MPC_ACC_DOWN_MAX"]), jerk),
            altitude_radius_m=values["NAV_MC_ALT_RAD"],
            heading=HeadingParameters.resolve(values),
            return_home=ReturnParameters.resolve(values),
        )

    def descent_m_s(self, height_m: float) -> float:
        """Descend slower near the ground: linear between the two heights."""
        low, high = self.slow_below_m, self.fast_above_m
        share = min(max((height_m - low) / (high - low), 0.0), 1.0) if high > low else 1.0
        return self.landing_m_s + share * (self.down_m_s - self.landing_m_s)


class NavigatorState(NamedTuple):
    """Which mode is led, and where."""

    mode: Mode = Mode.HOLD
    goal: Goal = Goal()
    leg: Leg = Leg()  # that leads to the goal; missions and returns have their own
    home_ned: Vector3 = ORIGIN
    return_home: ReturnHome = ReturnHome()
    speed_m_s: float = NAN  # horizontal; NaN: the usual one
    is_stopped: bool = True  # the place is held; until then only the speed is


class Navigator:
    """Leads the trajectory by the active mode."""

    def __init__(self, parameters: NavigatorParameters, mission: MissionFlight) -> None:
        self.parameters = parameters
        self.state = NavigatorState()
        self._mission = mission
        self._trajectory = Trajectory(ORIGIN, ORIGIN, ORIGIN)
        self._heading = Heading()

    def enter(
        self, mode: Mode, goal: Goal, home_ned: Vector3, estimate: Estimate, motion: Vector3
    ) -> None:
        """Begin a mode, out of the vehicle's own motion; `motion` is its acceleration, m/s2."""
        limit_xy, limit_z = self.parameters.agility_xy[0], self.parameters.agility_z[0]
        norm = math.hypot(motion[0], motion[1])
        shrink = limit_xy / norm if norm > limit_xy else 1.0
        start = (
            motion[0] * shrink,
            motion[1] * shrink,
            min(max(motion[2], -limit_z), limit_z),
        )
        position = estimate.position_ned
        self._trajectory = Trajectory(position, estimate.velocity_ned, start)
        self._heading = Heading(yaw_of(estimate.q_ned_frd))
        self.state = NavigatorState(
            mode,
            goal,
            _leg_of(mode, goal),
            home_ned,
            ReturnHome.start(position, home_ned, goal.yaw_rad, self.parameters.return_home),
            goal.speed_m_s,
            is_stopped=False,
        )

    def change_speed(self, speed_m_s: float) -> None:
        """Fly faster or slower from now on, horizontally; nothing positive: as usual."""
        self.state = self.state._replace(speed_m_s=speed_m_s if speed_m_s > 0.0 else NAN)

    def hold_where_takeoff_leads(self) -> None:
        """Go from take-off to hold without a break in the motion."""
        leg = _leg_of(Mode.HOLD, self.state.goal)
        self.state = self.state._replace(mode=Mode.HOLD, leg=leg)

    def takeoff_done(self, estimate: Estimate) -> bool:
        """Whether a take-off has brought the vehicle itself close enough to its altitude."""
        if self.state.mode is not Mode.TAKEOFF:
            return False
        left = self.state.goal.position_ned[2] - estimate.position_ned[2]
        return abs(left) < TAKEOFF_SHARE * self.parameters.altitude_radius_m

    def wait(self, estimate: Estimate) -> Setpoint:
        """Stay on the ground, ready: the trajectory starts where the vehicle stands."""
        self._trajectory.relocate(estimate.position_ned)
        self._hold_place()
        return Setpoint(
            position_ned=estimate.position_ned,
            velocity_ned=ORIGIN,
            yaw_rad=self._heading.yaw_rad,
        )

    def advance(self, estimate: Estimate) -> Setpoint:
        """Move the trajectory by one tick and give it as a setpoint."""
        trajectory, position = self._trajectory, estimate.position_ned
        leg, speed_down = self._lead(estimate)
        yaw, yaw_rate = self._turn(estimate, leg)
        stops = isnan(leg.target_ned[0])
        if not stops:
            self._hold_place()
        if not (self.state.is_stopped and trajectory.lags(position)):
            self._move(leg, speed_down)
        if stops and not self.state.is_stopped and self._is_slow(estimate):
            self._hold_place()
            trajectory.north.position, trajectory.east.position = position[0], position[1]
        x, y, z = trajectory.position
        if not self.state.is_stopped:
            x = y = NAN
        if not isnan(speed_down):  # a descent keeps its rate, wherever the ground is
            z = NAN
        return Setpoint((x, y, z), trajectory.velocity, trajectory.acceleration, yaw, yaw_rate)

    def _hold_place(self) -> None:
        if not self.state.is_stopped:
            self.state = self.state._replace(is_stopped=True)

    def _move(self, leg: Leg, speed_down: float) -> None:
        trajectory, parameters, target = self._trajectory, self.parameters, leg.target_ned
        if isnan(target[0]):
            trajectory.stop_xy(parameters.agility_xy)
        else:
            trajectory.approach_xy(target[0], target[1], self._speed_xy(), parameters.agility_xy)
        if not isnan(speed_down):
            trajectory.down.lead(speed_down, parameters.agility_z)
        elif isnan(target[2]):
            trajectory.down.lead(0.0, parameters.agility_z)
        else:
            up = parameters.takeoff_m_s if leg.climbs else parameters.up_m_s
            speed_max = parameters.down_m_s if target[2] > trajectory.down.position else up
            trajectory.approach_z(target[2], speed_max, parameters.agility_z)

    def _speed_xy(self) -> float:
        """Cruise at the speed that was asked for, by command or by the mission."""
        wanted = self.state.speed_m_s
        if isnan(wanted) and self.state.mode is Mode.MISSION:
            wanted = self._mission.state.speed_m_s
        if isnan(wanted):
            return self.parameters.cruise_m_s
        return min(wanted, self.parameters.speed_max_m_s)

    def _is_slow(self, estimate: Estimate) -> bool:
        """Whether the trajectory has stopped horizontally, and the vehicle nearly so."""
        vx, vy, _ = estimate.velocity_ned
        tx, ty, _ = self._trajectory.velocity
        return tx == 0.0 and ty == 0.0 and vx * vx + vy * vy < STOPPED_M_S**2

    def _lead(self, estimate: Estimate) -> tuple[Leg, float]:
        """Give the leg to fly, and the rate of a descent (NaN: none)."""
        mode, leg = self.state.mode, self.state.leg
        if mode is Mode.MISSION:
            leg = self._mission.update(estimate)
        elif mode is Mode.RTL:
            leg = self._return(estimate)
        if leg.lands:
            height = self.state.home_ned[2] - estimate.position_ned[2]
            return leg, self.parameters.descent_m_s(height)
        return leg, self.parameters.landing_m_s if leg.sinks else NAN

    def _return(self, estimate: Estimate) -> Leg:
        parameters, before = self.parameters.return_home, self.state.return_home
        yaw = yaw_of(estimate.q_ned_frd)
        now = before.advance(estimate.time_us, estimate.position_ned, yaw, parameters)
        if now is not before:
            self.state = self.state._replace(return_home=now)
        lands = now.phase is ReturnPhase.LAND
        return Leg(now.target_ned(parameters), now.yaw_rad, lands=lands)

    def _turn(self, estimate: Estimate, leg: Leg) -> tuple[float, float]:
        """Turn towards a distant target, or as the leg says; else come to rest."""
        heading, wanted, parameters = self._heading, leg.yaw_rad, self.parameters.heading
        if isnan(wanted):
            target = leg.target_ned
            x, y = target[0] - estimate.position_ned[0], target[1] - estimate.position_ned[1]
            far = math.hypot(x, y) > HEADING_RADIUS_M
            wanted = math.atan2(y, x) if far else heading.rest_rad(parameters)
        heading = self._heading = heading.turn(wanted, parameters)
        return heading.yaw_rad, heading.rate_rad_s


def _leg_of(mode: Mode, goal: Goal) -> Leg:
    """Give the leg of a mode that has but one."""
    if mode is Mode.HOLD:
        return Leg(goal.position_ned, goal.yaw_rad)
    if mode is Mode.TAKEOFF:  # straight up, and sideways only afterwards
        return Leg((NAN, NAN, goal.position_ned[2]), goal.yaw_rad, climbs=True)
    if mode is Mode.LAND:
        return Leg(NOWHERE, goal.yaw_rad, lands=True)
    return Leg(NOWHERE, goal.yaw_rad, sinks=True)  # a mode that needs sticks, without sticks
