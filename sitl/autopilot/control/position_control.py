"""Position and velocity control: a setpoint in NED becomes an attitude and a collective thrust.

The structure is that of PX4's multicopter position controller: a P controller on position gives a
velocity, a PID controller on velocity (in units of acceleration, D on the measured acceleration)
gives an acceleration, and that gives the thrust vector. Height is served before tilt, and the
integrators stop where the thrust is limited.
"""

from math import asin, atan2, cos, hypot, isnan, sin, sqrt
from typing import NamedTuple, Self

from sitl.autopilot.control.arithmetic import add, add_limited, add_or_zero, clamp, or_zero
from sitl.autopilot.control.hover_thrust import HoverThrust, HoverThrustParameters
from sitl.autopilot.control.limits import Limits
from sitl.autopilot.control.low_pass import low_pass_gain
from sitl.autopilot.control.setpoint import Setpoint
from sitl.autopilot.parameters import ParameterValues
from sitl.clock import TICK_S
from sitl.frames import GRAVITY_M_S2, quaternion_from_euler, yaw_of
from sitl.records.motion import Quaternion, Vector3
from sitl.records.sensing import Estimate


class AttitudeSetpoint(NamedTuple):
    """What the attitude controller is to do, and what was requested on the way there."""

    q_ned_frd: Quaternion
    thrust: float  # 0..1, collective
    yaw_rad: float
    yaw_rate_rad_s: float  # feed-forward about NED down
    velocity_ned: Vector3  # m/s, after limits
    acceleration_ned: Vector3  # m/s2


class VelocityGains(NamedTuple):
    """PID on velocity, in units of acceleration; D on the measured acceleration."""

    p: float
    i: float
    d: float


class PositionParameters(NamedTuple):
    """How hard errors of position and velocity are met, and what the vehicle can give."""

    p_xy: float  # 1/s, MPC_XY_P
    p_z: float  # 1/s, MPC_Z_P
    velocity_xy: VelocityGains  # MPC_XY_VEL_P_ACC, MPC_XY_VEL_I_ACC, MPC_XY_VEL_D_ACC
    velocity_z: VelocityGains  # MPC_Z_VEL_P_ACC, MPC_Z_VEL_I_ACC, MPC_Z_VEL_D_ACC
    derivative_gain: float  # of the low pass, MPC_VELD_LP
    speed_max_m_s: float  # MPC_XY_VEL_MAX
    land_speed_m_s: float  # MPC_LAND_SPEED
    thrust_max: float  # MPC_THR_MAX
    thrust_margin_xy: float  # MPC_THR_XY_MARG
    hover_thrust: HoverThrustParameters

    @classmethod
    def resolve(cls, values: ParameterValues) -> Self:
        """Take PX4's values, in SI units."""
        xy, z = (
            VelocityGains(*(values[f"MPC_{axis}_VEL_{letter}_ACC"] for letter in "PID"))
            for axis in ("XY", "Z")
        )
        return cls(
            p_xy=values["MPC_XY_P"],
            p_z=values["MPC_Z_P"],
            velocity_xy=xy,
            velocity_z=z,
            derivative_gain=low_pass_gain(values["MPC_VELD_LP"]),
            speed_max_m_s=values["MPC_XY_VEL_MAX"],
            land_speed_m_s=values["MPC_LAND_SPEED"],
            thrust_max=values["MPC_THR_MAX"],
            thrust_margin_xy=values["MPC_THR_XY_MARG"],
            hover_thrust=HoverThrustParameters.resolve(values),
        )


class VelocityState(NamedTuple):
    """What the velocity loop remembers from tick to tick."""

    integral: Vector3 = (0.0, 0.0, 0.0)  # m/s2
    acceleration: Vector3 = (0.0, 0.0, 0.0)  # m/s2, low-passed
    previous: Vector3 | None = None  # m/s, the velocity one tick ago
    thrust_down: float = 0.0  # low-passed like the acceleration, to be compared with it


AT_REST = VelocityState()


class PositionControl:
    """Keeps the state of the velocity loop, and what thrust the vehicle hovers at."""

    def __init__(self, parameters: PositionParameters) -> None:
        self.state = AT_REST
        self.hover = HoverThrust(parameters.hover_thrust)

    def reset(self) -> None:
        """Forget the past, while on the ground."""
        self.state = AT_REST

    def update(
        self,
        estimate: Estimate,
        setpoint: Setpoint,
        limits: Limits,
        parameters: PositionParameters,
        *,
        learns: bool,
    ) -> AttitudeSetpoint:
        """Advance by one tick; it learns the hover thrust only while flying freely."""
        before = self.state
        integral = self._learn_hover_thrust(parameters.hover_thrust) if learns else before.integral
        measured = _differentiate(before, estimate.velocity_ned, parameters.derivative_gain)
        velocity = _velocity_for(estimate.position_ned, setpoint, limits, parameters)
        present = _present_velocity(estimate, setpoint, parameters.land_speed_m_s)
        error = (velocity[0] - present[0], velocity[1] - present[1], velocity[2] - present[2])
        acceleration = _acceleration_for(
            error, integral, measured, setpoint.acceleration_ned, parameters
        )
        thrust_ned, collective = _thrust_for(acceleration, self.hover.value, limits, parameters)
        thrust_down = before.thrust_down
        thrust_down += parameters.derivative_gain * (thrust_ned[2] - thrust_down)
        integral = self._integrate(integral, error, acceleration, thrust_ned, limits, parameters)
        self.state = VelocityState(integral, measured, estimate.velocity_ned, thrust_down)
        yaw, yaw_rate = setpoint.yaw_rad, setpoint.yaw_rate_rad_s
        if isnan(yaw):  # no heading is requested: keep the present one
            yaw = yaw_of(estimate.q_ned_frd)
        q = _attitude(thrust_ned, yaw)
        return AttitudeSetpoint(q, collective, yaw, or_zero(yaw_rate), velocity, acceleration)

    def _learn_hover_thrust(self, parameters: HoverThrustParameters) -> Vector3:
        """Take the last tick's thrust and acceleration in, and give the integral for it."""
        (x, y, z), acceleration, _, thrust_down = self.state
        before = self.hover.value
        self.hover.learn(-thrust_down, -acceleration[2], parameters)
        # The integral follows, so that the thrust does not jump.
        return (x, y, (z - GRAVITY_M_S2) * (before / self.hover.value) + GRAVITY_M_S2)

    def _integrate(
        self,
        integral: Vector3,
        error: Vector3,
        acceleration: Vector3,
        thrust_ned: Vector3,
        limits: Limits,
        parameters: PositionParameters,
    ) -> Vector3:
        """Give the integral after this tick, which does not wind up where thrust is limited."""
        ex, ey, ez = or_zero(error[0]), or_zero(error[1]), error[2]
        at_floor = thrust_ned[2] >= -limits.thrust_min
        at_ceiling = thrust_ned[2] <= -parameters.thrust_max + 1e-9
        held_down = limits.speed_up_m_s < 0.0  # by the take-off ramp: nothing to learn from
        if (at_floor and ez >= 0.0) or (at_ceiling and ez <= 0.0) or held_down or isnan(ez):
            ez = 0.0
        # Tracking anti-windup: what the thrust can't give of the acceleration counts back.
        produced = GRAVITY_M_S2 / self.hover.value
        dx, dy = (
            acceleration[0] - thrust_ned[0] * produced,
            acceleration[1] - thrust_ned[1] * produced,
        )
        p_xy, gain_xy, _ = parameters.velocity_xy
        if hypot(acceleration[0], acceleration[1]) > 1e-6 + produced * hypot(
            thrust_ned[0], thrust_ned[1]
        ):
            back = 2.0 / p_xy
            ex, ey = ex - back * dx, ey - back * dy
        i_xy, i_z = gain_xy * TICK_S, parameters.velocity_z.i * TICK_S
        x, y, z = integral
        return (x + i_xy * ex, y + i_xy * ey, clamp(z + i_z * ez, GRAVITY_M_S2))


def _differentiate(before: VelocityState, velocity: Vector3, gain: float) -> Vector3:
    """Give the acceleration, low-passed."""
    previous = before.previous
    if previous is None:
        return before.acceleration
    x, y, z = before.acceleration
    return (
        x + gain * ((velocity[0] - previous[0]) / TICK_S - x),
        y + gain * ((velocity[1] - previous[1]) / TICK_S - y),
        z + gain * ((velocity[2] - previous[2]) / TICK_S - z),
    )


def _present_velocity(estimate: Estimate, setpoint: Setpoint, land_speed_m_s: float) -> Vector3:
    """Give the velocity to control.

    As in PX4 a climb or descent that is requested by velocity alone is held against the rate of the
    estimated position, which has less bias, blended in up to MPC_LAND_SPEED.
    """
    rate, requested = estimate.z_deriv_m_s, setpoint.velocity_ned[2]
    if isnan(rate) or isnan(requested) or not isnan(setpoint.position_ned[2]):
        return estimate.velocity_ned
    vx, vy, vz = estimate.velocity_ned
    weight = min(abs(requested) / land_speed_m_s, 1.0)
    return (vx, vy, weight * rate + (1.0 - weight) * vz)


def _velocity_for(
    position: Vector3, setpoint: Setpoint, limits: Limits, parameters: PositionParameters
) -> Vector3:
    """Position P controller plus the velocity requested; NaN where neither is given."""
    p_xy, p_z = parameters.p_xy, parameters.p_z
    px, py, pz = setpoint.position_ned
    vx, vy, vz = setpoint.velocity_ned
    x, y = add_limited(
        (p_xy * (px - position[0]), p_xy * (py - position[1])), (vx, vy), parameters.speed_max_m_s
    )
    z = add(p_z * (pz - position[2]), vz)
    return (x, y, max(min(z, limits.speed_down_m_s), -limits.speed_up_m_s))  # NaN stays


def _acceleration_for(
    error: Vector3,
    integral: Vector3,
    measured: Vector3,
    forward: Vector3,
    parameters: PositionParameters,
) -> Vector3:
    """PID on the velocity's error, plus the acceleration fed forward."""
    p_xy, _, d_xy = parameters.velocity_xy
    p_z, _, d_z = parameters.velocity_z
    return (
        add_or_zero(p_xy * error[0] + integral[0] - d_xy * measured[0], forward[0]),
        add_or_zero(p_xy * error[1] + integral[1] - d_xy * measured[1], forward[1]),
        add_or_zero(p_z * error[2] + integral[2] - d_z * measured[2], forward[2]),
    )


def _thrust_for(
    acceleration: Vector3, hover: float, limits: Limits, parameters: PositionParameters
) -> tuple[Vector3, float]:
    """Thrust vector (fractions, NED) for an acceleration: tilt first, then magnitude."""
    ax, ay, az = acceleration
    thrust_max = parameters.thrust_max
    scale = hover / GRAVITY_M_S2
    # Direction of the thrust, as if the vehicle held its height, within the tilt limit.
    horizontal, steepest = hypot(ax, ay), GRAVITY_M_S2 * limits.tilt_tan
    shrink = steepest / horizontal if horizontal > steepest else 1.0
    slope = shrink / GRAVITY_M_S2
    down = min(scale * az - hover, -limits.thrust_min)
    tx, ty = slope * ax * -down, slope * ay * -down
    # Height first, but a margin stays for the horizontal axes.
    horizontal = hypot(tx, ty)
    kept = min(horizontal, parameters.thrust_margin_xy)
    down = max(down, -sqrt(max(thrust_max**2 - kept * kept, 0.0)))
    room = sqrt(max(thrust_max**2 - down * down, 0.0))
    if horizontal > room:
        tx, ty = tx * room / horizontal, ty * room / horizontal
    return (tx, ty, down), sqrt(tx * tx + ty * ty + down * down)


def _attitude(thrust_ned: Vector3, yaw_rad: float) -> Quaternion:
    """Attitude whose -z axis lies along the thrust and whose heading is the yaw."""
    x, y, z = thrust_ned
    norm = sqrt(x * x + y * y + z * z)
    if norm == 0.0:  # no thrust is allowed at all: level
        return quaternion_from_euler(0.0, 0.0, yaw_rad)
    cos_yaw, sin_yaw = cos(yaw_rad), sin(yaw_rad)
    forward, right = (x * cos_yaw + y * sin_yaw) / norm, (y * cos_yaw - x * sin_yaw) / norm
    return quaternion_from_euler(asin(right), atan2(-forward, -z / norm), yaw_rad)
