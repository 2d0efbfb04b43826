"""Position and velocity control: a setpoint in NED becomes an attitude and a collective thrust.

The structure is that of PX4's multicopter position controller: a P controller on position gives a
velocity, a PID controller on velocity (in units of acceleration, D on the measured acceleration)
gives an acceleration, and that gives the thrust vector. Height is served before tilt, and the
integrators stop where the thrust is limited.
"""

import math
from math import isnan
from typing import NamedTuple

from sitl.autopilot.control.hover_thrust import HoverThrust
from sitl.autopilot.control.low_pass import low_pass_gain
from sitl.autopilot.control.setpoint import Setpoint
from sitl.autopilot.parameters import Parameters
from sitl.frames import GRAVITY_M_S2, quaternion_from_euler, yaw_of
from sitl.records.motion import Quaternion, Vector3
from sitl.records.sensing import Estimate


class AttitudeSetpoint(NamedTuple):
    """What the attitude controller is to do, and what was asked on the way there."""

    q_ned_frd: Quaternion
    thrust: float  # 0..1, collective
    yaw_rad: float
    yaw_rate_rad_s: float  # feed-forward about NED down
    velocity_ned: Vector3  # m/s, after limits
    acceleration_ned: Vector3  # m/s2


class Limits(NamedTuple):
    """What the controller may ask for in this phase of flight."""

    speed_up_m_s: float
    speed_down_m_s: float
    tilt_tan: float  # tangent of the steepest tilt
    thrust_min: float


class PositionControl:
    """Keeps the velocity integrator and the filtered acceleration between ticks."""

    def __init__(self, parameters: Parameters) -> None:
        self.integral: Vector3 = (0.0, 0.0, 0.0)  # m/s2
        self._acceleration: Vector3 = (0.0, 0.0, 0.0)
        self._previous_velocity: Vector3 | None = None
        self._thrust_down = 0.0  # low-passed like the acceleration, to be compared with it
        self._hover = HoverThrust(parameters)
        self.load(parameters)

    def load(self, parameters: Parameters) -> None:
        """Take gains and limits from the parameters."""
        p = parameters
        self.position_p = (p["MPC_XY_P"], p["MPC_Z_P"])
        self._xy_pid = (p["MPC_XY_VEL_P_ACC"], p["MPC_XY_VEL_I_ACC"], p["MPC_XY_VEL_D_ACC"])
        self._z_pid = (p["MPC_Z_VEL_P_ACC"], p["MPC_Z_VEL_I_ACC"], p["MPC_Z_VEL_D_ACC"])
        self._speed_max = p["MPC_XY_VEL_MAX"]
        self._hover.load(parameters)
        self._thrust_max = p["MPC_THR_MAX"]
        self._land_speed = p["MPC_LAND_SPEED"]
        self._xy_margin = p["MPC_THR_XY_MARG"]
        self._derivative_cutoff_hz = p["MPC_VELD_LP"]

    def reset(self) -> None:
        """Forget the past, while on the ground."""
        self.integral = (0.0, 0.0, 0.0)
        self._acceleration = (0.0, 0.0, 0.0)
        self._previous_velocity = None
        self._thrust_down = 0.0

    def reset_hover_thrust(self, value: float | None = None) -> None:
        """Start to learn the hover thrust anew, or know it already."""
        self._hover.reset(value)

    def learn_hover_thrust(self, dt_s: float) -> None:
        """Take the last tick's thrust and acceleration in; only while flying freely."""
        before = self._hover.value
        self._hover.update(-self._thrust_down, -self._acceleration[2], dt_s)
        # The integral follows, so that the thrust does not jump.
        ratio = before / self._hover.value
        x, y, z = self.integral
        self.integral = (x, y, (z - GRAVITY_M_S2) * ratio + GRAVITY_M_S2)

    def update(
        self, estimate: Estimate, setpoint: Setpoint, limits: Limits, dt_s: float
    ) -> AttitudeSetpoint:
        """Advance by one tick."""
        self._derivative_gain = low_pass_gain(self._derivative_cutoff_hz, dt_s)
        self._differentiate(estimate.velocity_ned, dt_s)
        velocity = self._velocity(estimate.position_ned, setpoint, limits)
        present = self._present_velocity(estimate, setpoint)
        acceleration = self._acceleration_for(present, velocity, setpoint)
        thrust_ned, collective = self._thrust_for(acceleration, limits)
        self._thrust_down += self._derivative_gain * (thrust_ned[2] - self._thrust_down)
        self._integrate(present, velocity, acceleration, thrust_ned, limits, dt_s)
        yaw, yaw_rate = setpoint.yaw_rad, setpoint.yaw_rate_rad_s
        if isnan(yaw):  # no heading asked: keep the present one
            yaw = yaw_of(estimate.q_ned_frd)
        return AttitudeSetpoint(
            _attitude(thrust_ned, yaw),
            collective,
            yaw,
            _or_zero(yaw_rate),
            velocity,
            acceleration,
        )

    def _differentiate(self, velocity: Vector3, dt_s: float) -> None:
        previous = self._previous_velocity
        self._previous_velocity = velocity
        if previous is None:
            return
        x, y, z = self._acceleration
        gain = self._derivative_gain
        self._acceleration = (
            x + gain * ((velocity[0] - previous[0]) / dt_s - x),
            y + gain * ((velocity[1] - previous[1]) / dt_s - y),
            z + gain * ((velocity[2] - previous[2]) / dt_s - z),
        )

    def _present_velocity(self, estimate: Estimate, setpoint: Setpoint) -> Vector3:
        """Give the velocity to control.

        As in PX4 a climb or descent that is asked for by velocity alone is held against the rate of
        the estimated position, which has less bias, blended in up to MPC_LAND_SPEED.
        """
        vx, vy, vz = estimate.velocity_ned
        rate, wanted = estimate.z_deriv_m_s, setpoint.velocity_ned[2]
        if isnan(rate) or isnan(wanted) or not isnan(setpoint.position_ned[2]):
            return estimate.velocity_ned
        weight = min(abs(wanted) / self._land_speed, 1.0)
        return (vx, vy, weight * rate + (1.0 - weight) * vz)

    def _velocity(self, position: Vector3, setpoint: Setpoint, limits: Limits) -> Vector3:
        """Position P controller plus the velocity asked for; NaN where neither is given."""
        p_xy, p_z = self.position_p
        px, py, pz = setpoint.position_ned
        vx, vy, vz = setpoint.velocity_ned
        x, y = _add_limited(
            (p_xy * (px - position[0]), p_xy * (py - position[1])), (vx, vy), self._speed_max
        )
        z = _add(p_z * (pz - position[2]), vz)
        return (x, y, z if isnan(z) else max(min(z, limits.speed_down_m_s), -limits.speed_up_m_s))

    def _acceleration_for(
        self, velocity: Vector3, velocity_setpoint: Vector3, setpoint: Setpoint
    ) -> Vector3:
        p_xy, _, d_xy = self._xy_pid
        p_z, _, d_z = self._z_pid
        ax, ay, az = self._acceleration
        ix, iy, iz = self.integral
        fx, fy, fz = setpoint.acceleration_ned
        x = _add(p_xy * (velocity_setpoint[0] - velocity[0]) + ix - d_xy * ax, fx)
        y = _add(p_xy * (velocity_setpoint[1] - velocity[1]) + iy - d_xy * ay, fy)
        z = _add(p_z * (velocity_setpoint[2] - velocity[2]) + iz - d_z * az, fz)
        return (_or_zero(x), _or_zero(y), _or_zero(z))

    def _thrust_for(self, acceleration: Vector3, limits: Limits) -> tuple[Vector3, float]:
        """Thrust vector (fractions, NED) for an acceleration: tilt first, then magnitude."""
        ax, ay, az = acceleration
        scale = self._hover.value / GRAVITY_M_S2
        # Direction of the thrust, as if the vehicle held its height, within the tilt limit.
        horizontal, steepest = math.hypot(ax, ay), GRAVITY_M_S2 * limits.tilt_tan
        shrink = steepest / horizontal if horizontal > steepest else 1.0
        slope = shrink / GRAVITY_M_S2
        down = min(scale * az - self._hover.value, -limits.thrust_min)
        tx, ty = slope * ax * -down, slope * ay * -down
        # Height first, but a margin stays for the horizontal axes.
        horizontal = math.hypot(tx, ty)
        kept = min(horizontal, self._xy_margin)
        down = max(down, -math.sqrt(max(self._thrust_max**2 - kept * kept, 0.0)))
        room = math.sqrt(max(self._thrust_max**2 - down * down, 0.0))
        if horizontal > room:
            tx, ty = tx * room / horizontal, ty * room / horizontal
        return (tx, ty, down), math.sqrt(tx * tx + ty * ty + down * down)

    def _integrate(
        self,
        velocity: Vector3,
        velocity_setpoint: Vector3,
        acceleration: Vector3,
        thrust_ned: Vector3,
        limits: Limits,
        dt_s: float,
    ) -> None:
        ex = _or_zero(velocity_setpoint[0] - velocity[0])
        ey = _or_zero(velocity_setpoint[1] - velocity[1])
        ez = _or_zero(velocity_setpoint[2] - velocity[2])
        at_floor = thrust_ned[2] >= -limits.thrust_min
        at_ceiling = thrust_ned[2] <= -self._thrust_max + 1e-9
        held_down = limits.speed_up_m_s < 0.0  # by the take-off ramp: nothing to learn from
        if (at_floor and ez >= 0.0) or (at_ceiling and ez <= 0.0) or held_down:
            ez = 0.0
        # Tracking anti-windup: what the thrust can't give of the acceleration counts back.
        produced = GRAVITY_M_S2 / self._hover.value
        dx, dy = (
            acceleration[0] - thrust_ned[0] * produced,
            acceleration[1] - thrust_ned[1] * produced,
        )
        if math.hypot(acceleration[0], acceleration[1]) > 1e-6 + produced * math.hypot(
            thrust_ned[0], thrust_ned[1]
        ):
            back = 2.0 / self._xy_pid[0]
            ex, ey = ex - back * dx, ey - back * dy
        i_xy, i_z = self._xy_pid[1] * dt_s, self._z_pid[1] * dt_s
        x, y, z = self.integral
        z = min(max(z + i_z * ez, -GRAVITY_M_S2), GRAVITY_M_S2)
        self.integral = (x + i_xy * ex, y + i_xy * ey, z)


def _attitude(thrust_ned: Vector3, yaw_rad: float) -> Quaternion:
    """Attitude whose -z axis lies along the thrust and whose heading is the yaw."""
    x, y, z = thrust_ned
    norm = math.sqrt(x * x + y * y + z * z)
    if norm == 0.0:  # no thrust is allowed at all: level
        return quaternion_from_euler(0.0, 0.0, yaw_rad)
    cos_yaw, sin_yaw = math.cos(yaw_rad), math.sin(yaw_rad)
    forward, right = (x * cos_yaw + y * sin_yaw) / norm, (y * cos_yaw - x * sin_yaw) / norm
    return quaternion_from_euler(math.asin(right), math.atan2(-forward, -z / norm), yaw_rad)


def _add(a: float, b: float) -> float:
    """Sum of what is given; NaN if neither is."""
    total = a + b
    if isnan(total):
        return b if isnan(a) else a
    return total


def _or_zero(value: float) -> float:
    return 0.0 if isnan(value) else value


def _add_limited(
    first: tuple[float, float], second: tuple[float, float], limit: float
) -> tuple[float, float]:
    """Add two horizontal vectors within a limit on the norm; the first is served first."""
    x, y = _add(first[0], second[0]), _add(first[1], second[1])
    norm = math.hypot(x, y)
    if not norm > limit:
        return (x, y)
    fx, fy = _or_zero(first[0]), _or_zero(first[1])
    sx, sy = _or_zero(second[0]), _or_zero(second[1])
    first_norm, second_norm = math.hypot(fx, fy), math.hypot(sx, sy)
    if first_norm >= limit:
        if limit == 0.0:
            return (0.0, 0.0)
        return (fx * limit / first_norm, fy * limit / first_norm)
    # How far along the second vector the limit is reached.
    ux, uy = sx / second_norm, sy / second_norm
    along = ux * fx + uy * fy
    room = -along + math.sqrt(along * along + limit * limit - first_norm * first_norm)
    return (fx + room * ux, fy + room * uy)
