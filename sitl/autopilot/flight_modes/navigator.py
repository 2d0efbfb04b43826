"""The automatic modes: take off, hold, return, land; a mode becomes a setpoint a tick.

Every mode moves one `Trajectory`, which starts from the vehicle's own motion when the mode begins.
"""

import math
from math import isnan
from typing import NamedTuple

from sitl.autopilot.control.heading import Heading, HeadingParameters
from sitl.autopilot.control.setpoint import Setpoint
from sitl.autopilot.control.trajectory import Agility, Trajectory
from sitl.autopilot.flight_modes.mission import Leg, MissionFlight
from sitl.autopilot.flight_modes.return_home import Phase, ReturnHome
from sitl.autopilot.parameters import Parameters
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


class Navigator:
    """Leads the trajectory by the active mode."""

    def __init__(self, parameters: Parameters, mission: MissionFlight) -> None:
        self._mission = mission
        self._leg = Leg()  # of the mission
        self._speed = NAN  # horizontal, m/s; NaN: the usual one
        self._mode = Mode.HOLD
        self._trajectory = Trajectory(ORIGIN, ORIGIN, ORIGIN)
        self._stopped = True  # the place is held; until then only the speed is
        self._goal = Goal()
        self._home_ned = ORIGIN
        self._heading = Heading()
        self._return_home = ReturnHome(parameters)
        self.load(parameters)

    def load(self, parameters: Parameters) -> None:
        """Take speeds and limits from the parameters."""
        p = parameters
        self._speed_max = p["MPC_XY_VEL_MAX"]
        self._cruise = min(p["MPC_XY_CRUISE"], self._speed_max)
        self._up, self._down = p["MPC_Z_V_AUTO_UP"], p["MPC_Z_V_AUTO_DN"]
        self._takeoff_speed, self._land_speed = p["MPC_TKO_SPEED"], p["MPC_LAND_SPEED"]
        self._slow_altitudes = (p["MPC_LAND_ALT2"], p["MPC_LAND_ALT1"])
        self._agility_xy = Agility(p["MPC_ACC_HOR"], p["MPC_JERK_AUTO"])
        self._agility_z = Agility(
            min(p["MPC_ACC_UP_MAX"], p["MPC_ACC_DOWN_MAX"]), p["MPC_JERK_AUTO"]
        )
        self._turning = HeadingParameters.resolve(p.values)
        self._altitude_radius = p["NAV_MC_ALT_RAD"]
        self._return_home.load(parameters)

    def enter(
        self, mode: Mode, goal: Goal, home_ned: Vector3, estimate: Estimate, motion: Vector3
    ) -> None:
        """Begin a mode, out of the vehicle's own motion; `motion` is its acceleration, m/s2."""
        limit_xy, limit_z = self._agility_xy[0], self._agility_z[0]
        norm = math.hypot(motion[0], motion[1])
        shrink = limit_xy / norm if norm > limit_xy else 1.0
        start = (
            motion[0] * shrink,
            motion[1] * shrink,
            min(max(motion[2], -limit_z), limit_z),
        )
        self._trajectory = Trajectory(estimate.position_ned, estimate.velocity_ned, start)
        self._stopped = False
        self._mode, self._goal, self._home_ned = mode, goal, home_ned
        self._leg, self._speed = Leg(), goal.speed_m_s
        self._heading = Heading(yaw_of(estimate.q_ned_frd))
        if mode is Mode.RTL:
            self._return_home.start(estimate.position_ned, home_ned, goal.yaw_rad)

    def change_speed(self, speed_m_s: float) -> None:
        """Fly faster or slower from now on, horizontally; nothing positive: as usual."""
        self._speed = speed_m_s if speed_m_s > 0.0 else NAN

    def hold_where_takeoff_leads(self) -> None:
        """Go from take-off to hold without a break in the motion."""
        self._mode = Mode.HOLD

    def takeoff_done(self, estimate: Estimate) -> bool:
        """Whether a take-off has brought the vehicle itself close enough to its altitude."""
        left = self._goal.position_ned[2] - estimate.position_ned[2]
        return self._mode is Mode.TAKEOFF and abs(left) < TAKEOFF_SHARE * self._altitude_radius

    @property
    def return_height_m(self) -> float:
        """How high above home the return leads."""
        return self._return_home.height_m

    def wait(self, estimate: Estimate) -> Setpoint:
        """Stay on the ground, ready: the trajectory starts where the vehicle stands."""
        self._trajectory.relocate(estimate.position_ned)
        self._stopped = True
        return Setpoint(
            position_ned=estimate.position_ned,
            velocity_ned=ORIGIN,
            yaw_rad=self._heading.yaw_rad,
        )

    def advance(self, estimate: Estimate) -> Setpoint:
        """Move the trajectory by one tick and give it as a setpoint."""
        trajectory, position = self._trajectory, estimate.position_ned
        target, speed_down = self._lead(estimate)
        yaw, yaw_rate = self._turn(estimate, target)
        stops = isnan(target[0])
        if not (self._stopped or stops):
            self._stopped = True
        if not (self._stopped and trajectory.lags(position)):
            self._move(target, speed_down)
        if stops and not self._stopped and self._is_slow(estimate):
            self._stopped = True
            trajectory.north.position, trajectory.east.position = position[0], position[1]
        x, y, z = trajectory.position
        if not self._stopped:
            x = y = NAN
        if not isnan(speed_down):  # a descent keeps its rate, wherever the ground is
            z = NAN
        return Setpoint((x, y, z), trajectory.velocity, trajectory.acceleration, yaw, yaw_rate)

    def _move(self, target: Vector3, speed_down: float) -> None:
        trajectory = self._trajectory
        if isnan(target[0]):
            trajectory.stop_xy(self._agility_xy)
        else:
            trajectory.approach_xy(target[0], target[1], self._speed_xy(), self._agility_xy)
        if not isnan(speed_down):
            trajectory.down.lead(speed_down, self._agility_z)
        elif isnan(target[2]):
            trajectory.down.lead(0.0, self._agility_z)
        else:
            climbs = self._mode is Mode.TAKEOFF or self._leg.climbs
            up = self._takeoff_speed if climbs else self._up
            speed_max = self._down if target[2] > trajectory.down.position else up
            trajectory.approach_z(target[2], speed_max, self._agility_z)

    def _speed_xy(self) -> float:
        """Cruise at the speed that was asked for, by command or by the mission."""
        for wanted in (self._speed, self._mission.speed_m_s):
            if not isnan(wanted):
                return min(wanted, self._speed_max)
            if self._mode is not Mode.MISSION:
                break
        return self._cruise

    def _is_slow(self, estimate: Estimate) -> bool:
        """Whether the trajectory has stopped horizontally, and the vehicle nearly so."""
        vx, vy, _ = estimate.velocity_ned
        tx, ty, _ = self._trajectory.velocity
        return tx == 0.0 and ty == 0.0 and vx * vx + vy * vy < STOPPED_M_S**2

    def _lead(self, estimate: Estimate) -> tuple[Vector3, float]:
        """Give the target (NaN: come to a stop), and the rate of a descent (NaN: none)."""
        mode, position = self._mode, estimate.position_ned
        stop: Vector3 = (NAN, NAN, NAN)
        if mode is Mode.RTL:
            yaw = yaw_of(estimate.q_ned_frd)
            phase, target = self._return_home.update(estimate.time_us, position, yaw)
            self._goal = self._goal._replace(yaw_rad=self._return_home.yaw_rad)
            return target, self._landing_speed(position) if phase is Phase.LAND else NAN
        if mode is Mode.MISSION:
            leg = self._leg = self._mission.update(estimate)
            self._goal = self._goal._replace(yaw_rad=leg.yaw_rad)
            return leg.target_ned, self._landing_speed(position) if leg.lands else NAN
        if mode is Mode.LAND:
            return stop, self._landing_speed(position)
        if mode is Mode.TAKEOFF:  # straight up, and sideways only afterwards
            return (NAN, NAN, self._goal.position_ned[2]), NAN
        if mode is Mode.HOLD:
            return self._goal.position_ned, NAN
        return stop, self._land_speed  # a mode that needs sticks, without sticks

    def _landing_speed(self, position: Vector3) -> float:
        """Descend slower near the ground: linear between MPC_LAND_ALT1 and MPC_LAND_ALT2."""
        height = self._home_ned[2] - position[2]
        low, high = self._slow_altitudes
        share = min(max((height - low) / (high - low), 0.0), 1.0) if high > low else 1.0
        return self._land_speed + share * (self._down - self._land_speed)

    def _turn(self, estimate: Estimate, target: Vector3) -> tuple[float, float]:
        """Turn towards a distant target, or to the goal's heading; else come to rest."""
        heading, wanted = self._heading, self._goal.yaw_rad
        if isnan(wanted):
            x, y = target[0] - estimate.position_ned[0], target[1] - estimate.position_ned[1]
            far = math.hypot(x, y) > HEADING_RADIUS_M
            wanted = math.atan2(y, x) if far else heading.rest_rad(self._turning)
        heading = self._heading = heading.turn(wanted, self._turning)
        return heading.yaw_rad, heading.rate_rad_s
