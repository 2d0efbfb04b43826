"""The physical world in one pybullet client: ground, collidable gates, and the vehicle's body."""

import math

import pybullet

from sitl.frames import GRAVITY_M_S2, flip, to_bullet_quaternion
from sitl.records.course import Gate
from sitl.records.motion import MotorThrusts, Quaternion, Vector3, VehicleState
from sitl.world.airframe import Airframe
from sitl.world.body import QuadrotorBody

GUI_GATE_COLOUR = (0.9, 0.35, 0.1, 1.0)


class World:
    """Everything that has mass or can be touched; advanced tick by tick."""

    def __init__(
        self, gates: tuple[Gate, ...], airframe: Airframe, *, tick_s: float, gui: bool = False
    ) -> None:
        self._client: int = pybullet.connect(pybullet.GUI if gui else pybullet.DIRECT)
        self._tick_s = tick_s
        pybullet.setGravity(0.0, 0.0, -GRAVITY_M_S2, physicsClientId=self._client)
        pybullet.setTimeStep(tick_s, physicsClientId=self._client)
        pybullet.setPhysicsEngineParameter(
            deterministicOverlappingPairs=1, physicsClientId=self._client
        )
        self._add_ground()
        self._gates = frozenset(self._add_gate(gate, visible=gui) for gate in gates)
        standing_ned = (0.0, 0.0, -airframe.collision_box_m[2] / 2.0)
        self.body = QuadrotorBody(self._client, airframe, position_ned=standing_ned, visual=gui)

    def close(self) -> None:
        """Free the physics client."""
        pybullet.disconnect(self._client)

    def step(self, motors: MotorThrusts, time_us: int) -> VehicleState:
        """Advance by one tick; return the true state at its end, which is `time_us`."""
        self.body.apply(motors, self._tick_s)
        pybullet.stepSimulation(self._client)
        return self.body.state(time_us)

    def touches_gate(self) -> bool:
        """Whether the vehicle is in contact with a gate after the last tick."""
        contacts = pybullet.getContactPoints(bodyA=self.body.body_id, physicsClientId=self._client)
        return bool(contacts) and any(contact[2] in self._gates for contact in contacts)

    def touches_gate_at(self, position_ned: Vector3, q_ned_frd: Quaternion) -> bool:
        """Whether the vehicle touches a gate where somebody else has put it, without a tick."""
        pybullet.resetBasePositionAndOrientation(
            self.body.body_id,
            flip(position_ned),
            to_bullet_quaternion(q_ned_frd),
            physicsClientId=self._client,
        )
        pybullet.performCollisionDetection(physicsClientId=self._client)
        return self.touches_gate()

    def _add_ground(self) -> None:
        shape = pybullet.createCollisionShape(pybullet.GEOM_PLANE, physicsClientId=self._client)
        pybullet.createMultiBody(baseCollisionShapeIndex=shape, physicsClientId=self._client)

    def _add_gate(self, gate: Gate, *, visible: bool) -> int:
        bars = gate.shape.bars()
        geometry = {
            "shapeTypes": [pybullet.GEOM_BOX] * len(bars),
            "halfExtents": [bar.half_extents for bar in bars],
            "physicsClientId": self._client,
        }
        centres = [flip(bar.centre) for bar in bars]
        turns = [to_bullet_quaternion(bar.q) for bar in bars]
        half = gate.yaw_rad / 2.0
        body: int = pybullet.createMultiBody(
            baseCollisionShapeIndex=pybullet.createCollisionShapeArray(
                collisionFramePositions=centres, collisionFrameOrientations=turns, **geometry
            ),
            baseVisualShapeIndex=pybullet.createVisualShapeArray(
                visualFramePositions=centres,
                visualFrameOrientations=turns,
                rgbaColors=[GUI_GATE_COLOUR] * len(bars),
                **geometry,
            )
            if visible
            else -1,
            basePosition=flip(gate.centre_ned),
            baseOrientation=to_bullet_quaternion((math.cos(half), 0.0, 0.0, math.sin(half))),
            physicsClientId=self._client,
        )
        return body
