"""The control cascade: position, velocity, attitude, body rates, mixer; one tick at a time."""

from collections.abc import Sequence
from typing import NamedTuple, Self

from sitl.autopilot.control.attitude_control import AttitudeParameters, turning_rates
from sitl.autopilot.control.limits import Limits
from sitl.autopilot.control.mixer import Mixer
from sitl.autopilot.control.position_control import (
    AttitudeSetpoint,
    PositionControl,
    PositionParameters,
)
from sitl.autopilot.control.rate_control import RateControl, RateParameters
from sitl.autopilot.control.setpoint import IDLE, Setpoint
from sitl.autopilot.parameters import ParameterValues
from sitl.frames import quaternion_from_euler, yaw_of
from sitl.records.motion import MotorThrusts, Vector3
from sitl.records.sensing import Estimate
from sitl.records.vehicle import NAN_VECTOR, AttitudeTarget

ZERO: Vector3 = (0.0, 0.0, 0.0)
STOPPED: MotorThrusts = (0.0, 0.0, 0.0, 0.0)
DIRECT = Setpoint()  # nothing for the position controller


class CascadeParameters(NamedTuple):
    """Those of each controller."""

    position: PositionParameters
    attitude: AttitudeParameters
    rate: RateParameters

    @classmethod
    def resolve(cls, values: ParameterValues) -> Self:
        """Take PX4's values, in SI units."""
        return cls(
            position=PositionParameters.resolve(values),
            attitude=AttitudeParameters.resolve(values),
            rate=RateParameters.resolve(values),
        )


class CascadeState(NamedTuple):
    """What each controller follows, and what came of it."""

    setpoint: Setpoint = IDLE
    attitude: AttitudeSetpoint = AttitudeSetpoint((1.0, 0.0, 0.0, 0.0), 0.0, 0.0, 0.0, ZERO, ZERO)
    rates_frd: Vector3 = ZERO
    motors: MotorThrusts = STOPPED
    saturated: Vector3 = ZERO  # the sign of the torque that the mixer had to cut


class Cascade:
    """Keeps the controllers, and what was last requested of each of them."""

    def __init__(
        self,
        parameters: CascadeParameters,
        rotor_positions_frd_m: Sequence[tuple[float, float]],
        rotor_yaw_moments_m: Sequence[float],
    ) -> None:
        self.parameters = parameters
        self.state = CascadeState()
        self._position = PositionControl(parameters.position)
        self._rate = RateControl()
        self._mixer = Mixer(rotor_positions_frd_m, rotor_yaw_moments_m)

    def start_airborne(self, hover_thrust: float) -> None:
        """Begin in the air, where a hover needs no settling."""
        self._rate.reset()
        self.state = self.state._replace(saturated=ZERO)
        self._position.reset()
        self._position.hover.know(hover_thrust, self.parameters.position.hover_thrust)

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
        attitude = self._position.update(
            estimate, setpoint, limits, self.parameters.position, learns=clear
        )
        return self._drive(estimate, setpoint, attitude, landed=landed)

    def fly_attitude(
        self, estimate: Estimate, target: AttitudeTarget, *, landed: bool
    ) -> MotorThrusts:
        """Follow an attitude or body rates, and a thrust, for one tick."""
        self._position.reset()
        q = target.q_ned_frd or estimate.q_ned_frd
        yaw_rate = target.rates_frd[2] if target.q_ned_frd else 0.0
        attitude = AttitudeSetpoint(q, target.thrust, yaw_of(q), yaw_rate, NAN_VECTOR, NAN_VECTOR)
        rates_frd = None if target.q_ned_frd else target.rates_frd
        return self._drive(estimate, DIRECT, attitude, rates_frd, landed=landed)

    def idle(self, estimate: Estimate, thrust: float) -> MotorThrusts:
        """Stay level on the ground with the rotors turning; the integrators start afresh."""
        self._position.reset()
        yaw = yaw_of(estimate.q_ned_frd)
        level = quaternion_from_euler(0.0, 0.0, yaw)
        attitude = AttitudeSetpoint(level, thrust, yaw, 0.0, NAN_VECTOR, IDLE.acceleration_ned)
        return self._drive(estimate, IDLE, attitude, landed=True)

    def stop(self, estimate: Estimate) -> MotorThrusts:
        """Rotors off."""
        self._position.reset()
        self._position.hover.reset(self.parameters.position.hover_thrust)
        self._rate.reset()
        q = estimate.q_ned_frd
        attitude = AttitudeSetpoint(q, 0.0, yaw_of(q), 0.0, NAN_VECTOR, IDLE.acceleration_ned)
        self.state = CascadeState(IDLE, attitude)
        return STOPPED

    def _drive(
        self,
        estimate: Estimate,
        setpoint: Setpoint,
        attitude: AttitudeSetpoint,
        rates_frd: Vector3 | None = None,
        *,
        landed: bool,
    ) -> MotorThrusts:
        """Turn an attitude setpoint, or only its thrust and body rates, into motor thrusts."""
        parameters = self.parameters
        if rates_frd is None:
            q, yaw_rate = attitude.q_ned_frd, attitude.yaw_rate_rad_s
            rates_frd = turning_rates(estimate.q_ned_frd, q, yaw_rate, parameters.attitude)
        saturated = self.state.saturated
        torque = self._rate.update(
            estimate.rates_frd, rates_frd, parameters.rate, saturated=saturated, landed=landed
        )
        motors, saturated = self._mixer.mix(torque, attitude.thrust)
        self.state = CascadeState(setpoint, attitude, rates_frd, motors, saturated)
        return motors
