"""The quadrotor as a rigid body in pybullet: rotors with lag, thrust, drag, contact.

Rotor model (Gazebo's multicopter motor model): a thrust fraction u asks for the speed
omega_max sqrt(u), so thrust is linear in the command: that is THR_MDL_FAC 0 on linear actuators, as
in PX4's SIH (or THR_MDL_FAC 1 on motors whose speed follows the signal). The speed follows with
a first-order lag, quicker up than down. Each rotor gives thrust k_T omega^2, the reaction moment
k_M thrust, and an in-plane drag proportional to omega and to the air speed of its hub.
"""

import math

import pybullet

from sitl.frames import (
    GRAVITY_M_S2,
    flip,
    from_bullet_quaternion,
    quaternion_from_euler,
    rotate_inverse,
    to_bullet_quaternion,
)
from sitl.records.motion import MotorThrusts, Quaternion, Vector3, VehicleState
from sitl.world.airframe import ROTORS, Airframe, Rotors

ORIGIN = (0.0, 0.0, 0.0)
FRICTION = 0.8  # assumption: rubber feet on a hard floor
VISUAL_RGBA = (0.15, 0.15, 0.17, 1.0)

# Position (m) and velocity (m/s) NED, q_ned_frd, rates (rad/s) FRD; a plain tuple, made every tick.
BodyMotion = tuple[Vector3, Vector3, Quaternion, Vector3]


class QuadrotorBody:
    """One vehicle in a pybullet client whose world frame is NWU.

    The owner sets gravity and time step, and each tick calls `apply`, then `stepSimulation`, then
    `state`. Positions are those of the centre of mass.
    """

    def __init__(
        self,
        client: int,
        airframe: Airframe,
        *,
        position_ned: Vector3,
        yaw_rad: float = 0.0,
        visual: bool = False,
    ) -> None:
        self.wind_ned: Vector3 = ORIGIN  # m/s, the air's velocity
        self._client = client
        self._airframe = airframe
        self._max_speed = airframe.rotors.max_speed_rad_s
        self._rotors = _rotor_constants(airframe.rotors)
        self._lag_dt_s = self._lag_up = self._lag_down = 0.0
        self._omega = [0.0] * ROTORS  # rad/s
        self._step_s = 0.0  # how long the last step was; 0: there was none
        self._previous_velocity_ned: Vector3 = ORIGIN
        self._motion: BodyMotion | None = None  # none: a step has changed it
        self.body_id = self._create(visual=visual)
        self.reset(
            position_ned=position_ned,
            velocity_ned=ORIGIN,
            q_ned_frd=quaternion_from_euler(0.0, 0.0, yaw_rad),
        )

    def reset(
        self,
        *,
        position_ned: Vector3,
        velocity_ned: Vector3,
        q_ned_frd: Quaternion,
        thrust: float = 0.0,
    ) -> None:
        """Put the body anywhere, not turning, with rotors at the speed of a thrust fraction."""
        pybullet.resetBasePositionAndOrientation(
            self.body_id,
            flip(position_ned),
            to_bullet_quaternion(q_ned_frd),
            physicsClientId=self._client,
        )
        pybullet.resetBaseVelocity(
            self.body_id, flip(velocity_ned), ORIGIN, physicsClientId=self._client
        )
        self._omega = [self._max_speed * math.sqrt(thrust)] * ROTORS
        self._previous_velocity_ned = self._read()[1]
        self._step_s = 0.0

    def apply(self, motors: MotorThrusts, dt_s: float) -> None:
        """Advance the rotors by `dt_s` and put their forces and the drag on the body."""
        motion = self._motion or self._read()
        force_frd, torque_frd = self._forces(motion, self._spin(motors, dt_s))
        body, client, link = self.body_id, self._client, pybullet.LINK_FRAME  # no keywords: faster
        pybullet.applyExternalForce(body, -1, flip(force_frd), ORIGIN, link, client)
        pybullet.applyExternalTorque(body, -1, flip(torque_frd), link, client)
        self._previous_velocity_ned = motion[1]
        self._step_s = dt_s
        self._motion = None

    def state(self, time_us: int) -> VehicleState:
        """Read the true state; the specific force is the mean over the last step, with contact."""
        position, velocity, q_ned_frd, rates = self._motion or self._read()
        previous, step_s = self._previous_velocity_ned, self._step_s
        rate = 1.0 / step_s if step_s else 0.0
        specific_force_ned = (
            (velocity[0] - previous[0]) * rate,
            (velocity[1] - previous[1]) * rate,
            (velocity[2] - previous[2]) * rate - GRAVITY_M_S2,
        )
        return VehicleState(
            time_us,
            position,
            velocity,
            q_ned_frd,
            rates,
            rotate_inverse(q_ned_frd, specific_force_ned),
        )

    @property
    def rotor_speeds_rad_s(self) -> tuple[float, float, float, float]:
        """Rotor speeds, in the airframe's rotor order."""
        a, b, c, d = self._omega
        return (a, b, c, d)

    def _read(self) -> BodyMotion:
        """Ask the physics engine; kept until the next step."""
        body, client = self.body_id, self._client
        position, orientation = pybullet.getBasePositionAndOrientation(body, client)
        velocity, rates = pybullet.getBaseVelocity(body, client)
        q_ned_frd = from_bullet_quaternion(orientation)
        rates_frd = rotate_inverse(q_ned_frd, flip(rates))
        self._motion = motion = (flip(position), flip(velocity), q_ned_frd, rates_frd)
        return motion

    def _spin(self, motors: MotorThrusts, dt_s: float) -> list[float]:
        if dt_s != self._lag_dt_s:
            self._lag_dt_s = dt_s
            rotors = self._airframe.rotors
            self._lag_up = 1.0 - math.exp(-dt_s / rotors.time_constant_up_s)
            self._lag_down = 1.0 - math.exp(-dt_s / rotors.time_constant_down_s)
        omega = self._omega
        for index, thrust in enumerate(motors):
            error = self._max_speed * math.sqrt(min(max(thrust, 0.0), 1.0)) - omega[index]
            omega[index] += error * (self._lag_up if error > 0.0 else self._lag_down)
        return omega

    def _forces(self, motion: BodyMotion, omega: list[float]) -> tuple[Vector3, Vector3]:
        """Sum thrust, reaction moment and drag over the rotors, about the centre of mass, FRD."""
        wind = self.wind_ned
        _, (vx, vy, vz), q_ned_frd, (p, q, yaw_rate) = motion
        air = rotate_inverse(q_ned_frd, (vx - wind[0], vy - wind[1], vz - wind[2]))
        rotors, body_drag = self._airframe.rotors, self._airframe.drag
        drag, k_thrust = rotors.drag_coefficient_n_s2_m, rotors.thrust_coefficient_n_s2
        kx, ky, kz = body_drag.linear_n_s_m
        fx, fy, fz = -kx * air[0], -ky * air[1], -kz * air[2]
        kx, ky, kz = body_drag.angular_n_m_s
        roll, pitch, yaw = -kx * p, -ky * q, -kz * yaw_rate
        for (x, y, moment), speed in zip(self._rotors, omega, strict=True):
            thrust = k_thrust * speed * speed
            rotor_drag = drag * speed
            dx = -rotor_drag * (air[0] - yaw_rate * y)
            dy = -rotor_drag * (air[1] + yaw_rate * x)
            fx += dx
            fy += dy
            fz -= thrust
            roll -= y * thrust
            pitch += x * thrust
            yaw += moment * thrust + x * dy - y * dx
        return (fx, fy, fz), (roll, pitch, yaw)

    def _create(self, *, visual: bool) -> int:
        half = [length / 2 for length in self._airframe.collision_box_m]
        client = self._client
        box = pybullet.createCollisionShape(
            pybullet.GEOM_BOX, halfExtents=half, physicsClientId=client
        )
        look = -1
        if visual:
            look = pybullet.createVisualShape(
                pybullet.GEOM_BOX, halfExtents=half, rgbaColor=VISUAL_RGBA, physicsClientId=client
            )
        body = pybullet.createMultiBody(self._airframe.mass_kg, box, look, physicsClientId=client)
        pybullet.changeDynamics(
            body,
            -1,
            localInertiaDiagonal=self._airframe.inertia_kg_m2,
            linearDamping=0.0,  # drag is ours
            angularDamping=0.0,
            lateralFriction=FRICTION,
            restitution=0.0,
            physicsClientId=client,
        )
        return int(body)


def _rotor_constants(rotors: Rotors) -> tuple[Vector3, ...]:
    """Give each rotor's x, y (m) and the signed reaction moment per thrust (m), FRD."""
    return tuple(
        (x, y, moment)
        for (x, y), moment in zip(rotors.positions_frd_m, rotors.yaw_moments_m, strict=True)
    )
