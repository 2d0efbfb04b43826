"""The control cascade: position, velocity, attitude, body rates, mixer; one tick at a time."""

import math
from collections.abc import Sequence

from sitl.autopilot.control.attitude_control import AttitudeControl
from sitl.autopilot.control.mixer import Mixer
from sitl.autopilot.control.position_control import AttitudeSetpoint, Limits, PositionControl
from sitl.autopilot.control.rate_control import RateControl
from sitl.autopilot.control.setpoint import IDLE, Setpoint
from sitl.autopilot.parameters import Parameters
from sitl.clock import SECOND_US, TICK_US
from sitl.frames import quaternion_from_euler, yaw_of
from sitl.records.motion import MotorThrusts, Vector3
from sitl.records.sensing import Estimate
from sitl.records.vehicle import NAN_VECTOR, AttitudeTarget

ZERO: Vector3 = (0.0, 0.0, 0.0)
STOPPED: MotorThrusts = (0.0, 0.0, 0.0, 0.0)
TICK_S = TICK_US / SECOND_US
DIRECT = Setpoint()  # nothing for the position controller


class Cascade:
    """Keeps the controllers, and what was last asked of each of them."""

    def __init__(
        self,
        parameters: Parameters,
        rotor_positions_frd_m: Sequence[tuple[float, float]],
        rotor_yaw_moments_m: Sequence[float],
    ) -> None:
        self.position = PositionControl(parameters)
        self._attitude = AttitudeControl(parameters)
        self._rate = RateControl(parameters)
        self._mixer = Mixer(rotor_positions_frd_m, rotor_yaw_moments_m)
        self._saturated = ZERO
        self.setpoint: Setpoint = IDLE
        self.asked = AttitudeSetpoint((1.0, 0.0, 0.0, 0.0), 0.0, 0.0, 0.0, ZERO, ZERO)
        self.rates_frd: Vector3 = ZERO
        self.motors: MotorThrusts = STOPPED

    def load(self, parameters: Parameters) -> None:
        """Take changed parameters in."""
        for controller in (self.position, self._attitude, self._rate):
            controller.load(parameters)

    def start_airborne(self, hover_thrust: float) -> None:
        """Begin in the air, where a hover needs no settling."""
        self._rate.reset()
        self._saturated = ZERO
        self.position.reset()
        self.position.reset_hover_thrust(hover_thrust)

    def fly(
        self,
        estimate: Estimate,
        setpoint: Setpoint,
        limits: Limits,
        *,
        landed: bool,
        clear: bool,
    ) -> MotorThrusts:
        """Follow a setpoint for one tick; the hover thrust is learnt clear of the ground."""
        if clear:
            self.position.learn_hover_thrust(TICK_S)
        asked = self.position.update(estimate, setpoint, limits, TICK_S)
        self.setpoint, self.asked = setpoint, asked
        return self._turn(estimate, asked, landed=landed)

    def fly_attitude(
        self, estimate: Estimate, target: AttitudeTarget, *, landed: bool
    ) -> MotorThrusts:
        """Follow an attitude or body rates, and a thrust, for one tick."""
        self.position.reset()
        self.setpoint = DIRECT
        q = target.q_ned_frd or estimate.q_ned_frd
        yaw, thrust = yaw_of(q), target.thrust
        yaw_rate = target.rates_frd[2] if target.q_ned_frd else 0.0
        nothing = NAN_VECTOR
        self.asked = AttitudeSetpoint(q, thrust, yaw, yaw_rate, nothing, nothing)
        if target.q_ned_frd is None:
            self.rates_frd = target.rates_frd
            return self._drive(estimate, thrust, landed=landed)
        return self._turn(estimate, self.asked, landed=landed)

    def idle(self, estimate: Estimate, thrust: float) -> MotorThrusts:
        """Stay level on the ground with the rotors turning; the integrators start afresh."""
        yaw = yaw_of(estimate.q_ned_frd)
        self.position.reset()
        self.setpoint = IDLE
        level = quaternion_from_euler(0.0, 0.0, yaw)
        self.asked = AttitudeSetpoint(level, thrust, yaw, 0.0, NAN_VECTOR, IDLE.acceleration_ned)
        return self._turn(estimate, self.asked, landed=True)

    def stop(self, estimate: Estimate) -> MotorThrusts:
        """Rotors off."""
        yaw = yaw_of(estimate.q_ned_frd)
        self.position.reset()
        self.position.reset_hover_thrust()
        self._rate.reset()
        self._saturated, self.rates_frd, self.setpoint = ZERO, ZERO, IDLE
        q = estimate.q_ned_frd
        self.asked = AttitudeSetpoint(q, 0.0, yaw, 0.0, NAN_VECTOR, IDLE.acceleration_ned)
        self.motors = STOPPED
        return STOPPED

    def _turn(self, estimate: Estimate, asked: AttitudeSetpoint, *, landed: bool) -> MotorThrusts:
        q = estimate.q_ned_frd
        self.rates_frd = self._attitude.update(q, asked.q_ned_frd, asked.yaw_rate_rad_s)
        return self._drive(estimate, asked.thrust, landed=landed)

    def _drive(self, estimate: Estimate, thrust: float, *, landed: bool) -> MotorThrusts:
        """Turn the body rates asked for into motor thrusts."""
        torque = self._rate.update(
            estimate.rates_frd, self.rates_frd, TICK_S, saturated=self._saturated, landed=landed
        )
        mixed = self._mixer.mix(torque, thrust)
        self._saturated = mixed.saturated
        self.motors = mixed.motors
        return mixed.motors


def tilt_tan(tilt_deg: float) -> float:
    """Tangent of a tilt limit, for `Limits`."""
    return math.tan(math.radians(min(tilt_deg, 89.0)))
