"""The automatic modes: take off, hold, return, land; a mode becomes a setpoint a tick.

Every mode moves one `Trajectory`, which starts from the vehicle's own motion when the mode begins.
"""

import math
from math import isnan
from typing import NamedTuple

from sitl.autopilot.parameters import Parameters
from sitl.autopilot.return_home import Phase, ReturnHome
from sitl.autopilot.setpoint import Setpoint
from sitl.autopilot.trajectory import TICK_S, Trajectory, approach_speed
from sitl.frames import wrap_pi, yaw_of
from sitl.modes import Mode
from sitl.records import Estimate, Vector3

NAN = math.nan
ORIGIN: Vector3 = (0.0, 0.0, 0.0)
HEADING_RADIUS_M = 2.0  # closer to the goal than this, the heading stays


class Goal(NamedTuple):
    """Where a mode is to lead, local NED; NaN where it stays as it is."""

    position_ned: Vector3 = (NAN, NAN, NAN)  # m
    yaw_rad: float = NAN


class Navigator:
    """Leads the trajectory by the active mode."""

    def __init__(self, parameters: Parameters) -> None:
        self._mode = Mode.HOLD
        self._trajectory = Trajectory(ORIGIN, ORIGIN, ORIGIN)
        self._goal = Goal()
        self._home_ned = ORIGIN
        self._yaw_rad = 0.0
        self._return_home = ReturnHome(parameters)
        self.load(parameters)

    def load(self, parameters: Parameters) -> None:
        """Take speeds and limits from the parameters."""
        p = parameters
        self._cruise = min(p["MPC_XY_CRUISE"], p["MPC_XY_VEL_MAX"])
        self._up, self._down = p["MPC_Z_V_AUTO_UP"], p["MPC_Z_V_AUTO_DN"]
        self._takeoff_speed, self._land_speed = p["MPC_TKO_SPEED"], p["MPC_LAND_SPEED"]
        self._slow_altitudes = (p["MPC_LAND_ALT2"], p["MPC_LAND_ALT1"])
        self._accelerations = (p["MPC_ACC_HOR"], min(p["MPC_ACC_UP_MAX"], p["MPC_ACC_DOWN_MAX"]))
        self._jerk = p["MPC_JERK_AUTO"]
        self._yaw_step = math.radians(p["MPC_YAWRAUTO_MAX"]) * TICK_S
        self._altitude_radius = p["NAV_MC_ALT_RAD"]
        self._return_home.load(parameters)

    def enter(
        self, mode: Mode, goal: Goal, home_ned: Vector3, estimate: Estimate, motion: Vector3
    ) -> None:
        """Begin a mode, out of the vehicle's own motion; `motion` is its acceleration, m/s2."""
        limit_xy, limit_z = self._accelerations
        norm = math.hypot(motion[0], motion[1])
        shrink = limit_xy / norm if norm > limit_xy else 1.0
        start = (
            motion[0] * shrink,
            motion[1] * shrink,
            min(max(motion[2], -limit_z), limit_z),
        )
        self._trajectory = Trajectory(estimate.position_ned, estimate.velocity_ned, start)
        self._mode, self._goal, self._home_ned = mode, goal, home_ned
        self._yaw_rad = yaw_of(estimate.q_ned_frd)
        if mode is Mode.RTL:
            self._return_home.start(estimate.position_ned, home_ned)

    def hold_where_takeoff_leads(self) -> None:
        """Go from take-off to hold without a break in the motion."""
        self._mode = Mode.HOLD

    def takeoff_done(self, estimate: Estimate) -> bool:
        """Whether a take-off has brought the vehicle itself close enough to its altitude."""
        left = self._goal.position_ned[2] - estimate.position_ned[2]
        return self._mode is Mode.TAKEOFF and abs(left) < self._altitude_radius

    @property
    def return_height_m(self) -> float:
        """How high above home the return leads."""
        return self._return_home.height_m

    def wait(self, estimate: Estimate) -> Setpoint:
        """Stay on the ground, ready: the trajectory starts where the vehicle stands."""
        self._trajectory = Trajectory(estimate.position_ned, ORIGIN, ORIGIN)
        return Setpoint(
            position_ned=estimate.position_ned, velocity_ned=ORIGIN, yaw_rad=self._yaw_rad
        )

    def advance(self, estimate: Estimate) -> Setpoint:
        """Move the trajectory by one tick and give it as a setpoint."""
        trajectory = self._trajectory
        target, speed_down = self._lead(estimate)
        yaw, yaw_rate = self._turn(estimate, target)
        if not trajectory.lags(estimate.position_ned):
            speeds = (*self._speed_xy(target), self._speed_z(target[2], speed_down))
            trajectory.move(speeds, self._accelerations, self._jerk)
        x, y, z = trajectory.position
        descends = not isnan(speed_down)  # then only the rate counts, wherever the ground is
        return Setpoint(
            (x, y, NAN if descends else z),
            trajectory.velocity,
            trajectory.acceleration,
            yaw,
            yaw_rate,
        )

    def _lead(self, estimate: Estimate) -> tuple[Vector3, float]:
        """Give the target (NaN: come to a stop), and the rate of a descent (NaN: none)."""
        mode, position = self._mode, estimate.position_ned
        stop: Vector3 = (NAN, NAN, NAN)
        if mode is Mode.RTL:
            phase, target = self._return_home.update(estimate.time_us, position)
            return target, self._landing_speed(position) if phase is Phase.LAND else NAN
        if mode is Mode.LAND:
            return stop, self._landing_speed(position)
        if mode is Mode.TAKEOFF:  # straight up, and sideways only afterwards
            return (NAN, NAN, self._goal.position_ned[2]), NAN
        if mode is Mode.HOLD:
            return self._goal.position_ned, NAN
        return stop, self._land_speed  # a mode that needs sticks, without sticks

    def _speed_xy(self, target: Vector3) -> tuple[float, float]:
        if isnan(target[0]) or isnan(target[1]):
            return (0.0, 0.0)
        position = self._trajectory.position
        x, y = target[0] - position[0], target[1] - position[1]
        distance = math.hypot(x, y)
        if distance < 1e-6:
            return (0.0, 0.0)
        speed = min(self._cruise, approach_speed(distance, self._accelerations[0], self._jerk))
        return (x / distance * speed, y / distance * speed)

    def _speed_z(self, target: float, speed_down: float) -> float:
        if not isnan(speed_down):
            return speed_down
        if isnan(target):
            return 0.0
        left = target - self._trajectory.position[2]
        speed = approach_speed(abs(left), self._accelerations[1], self._jerk)
        up = self._takeoff_speed if self._mode is Mode.TAKEOFF else self._up
        return min(speed, self._down) if left > 0.0 else -min(speed, up)

    def _landing_speed(self, position: Vector3) -> float:
        """Descend slower near the ground: linear between MPC_LAND_ALT1 and MPC_LAND_ALT2."""
        height = self._home_ned[2] - position[2]
        low, high = self._slow_altitudes
        share = min(max((height - low) / (high - low), 0.0), 1.0) if high > low else 1.0
        return self._land_speed + share * (self._down - self._land_speed)

    def _turn(self, estimate: Estimate, target: Vector3) -> tuple[float, float]:
        """Turn towards a distant target, or to the goal's heading, at no more than the limit."""
        wanted = self._goal.yaw_rad
        if isnan(wanted):
            x, y = target[0] - estimate.position_ned[0], target[1] - estimate.position_ned[1]
            if not math.hypot(x, y) > HEADING_RADIUS_M:
                return self._yaw_rad, 0.0
            wanted = math.atan2(y, x)
        left = wrap_pi(wanted - self._yaw_rad)
        step = min(max(left, -self._yaw_step), self._yaw_step)
        self._yaw_rad = wrap_pi(self._yaw_rad + step)
        return self._yaw_rad, step / TICK_S
