"""The autopilot: what the world calls, a tick at a time."""

from collections.abc import Sequence

from sitl.autopilot.cascade import Cascade, tilt_tan
from sitl.autopilot.parameters import Parameters
from sitl.autopilot.position_control import Limits
from sitl.autopilot.setpoint import Setpoint
from sitl.frames import yaw_of
from sitl.modes import BASE_ARMED, BASE_ATTITUDE, Mode, mode_of
from sitl.records import Estimate, MotorThrusts, StatusText, Vector3
from sitl.vehicle_records import (
    Command,
    CommandResult,
    OffboardSetpoint,
    SetpointEcho,
    VehicleStatus,
)

ACCEPTED = 0
UNSUPPORTED = 3


class Autopilot:
    """PX4-style flight control of one quadrotor."""

    def __init__(
        self,
        parameters: Parameters,
        *,
        rotor_positions_frd_m: Sequence[tuple[float, float]],
        rotor_yaw_moments_m: Sequence[float],
        hover_thrust: float,
        home: Vector3,
    ) -> None:
        self.parameters = parameters
        self._cascade = Cascade(parameters, rotor_positions_frd_m, rotor_yaw_moments_m)
        self._hover_thrust = hover_thrust
        self._home = home
        self._armed = False
        self._mode = Mode.HOLD
        self._version = parameters.version
        self._estimate: Estimate | None = None
        self._setpoint = OffboardSetpoint(time_us=0)
        self._texts: list[StatusText] = []

    def start_airborne(self) -> None:
        """Begin in the air, armed, in OFFBOARD, hovering: for training, never for a flight."""
        self._armed = True
        self._mode = Mode.OFFBOARD
        self._cascade.position.reset(self._cascade.position.hover_integral(self._hover_thrust))

    def step(self, estimate: Estimate) -> MotorThrusts:
        """Advance by one tick of 4 ms."""
        self._estimate = estimate
        if not self._armed:
            return self._cascade.stop(estimate)
        s = self._setpoint
        setpoint = Setpoint(
            s.position_ned, s.velocity_ned, s.acceleration_ned, s.yaw_rad, s.yaw_rate_rad_s
        )
        limits = Limits(3.0, 1.5, tilt_tan(45.0), 0.12)
        return self._cascade.fly(estimate, setpoint, limits, landed=False)

    def command(self, command: Command) -> CommandResult | None:
        """Obey or refuse a MAVLink command; None where PX4 stays silent."""
        if command.command == 400:
            self._armed = command.params[0] == 1.0
            return CommandResult(result=ACCEPTED)
        if command.command == 176:
            return self.set_mode(int(command.params[1]), int(command.params[2]))
        return CommandResult(result=UNSUPPORTED)

    def set_mode(self, main: int, sub: int) -> CommandResult:
        """Change the mode, by PX4's numbers."""
        self._mode = mode_of(main, sub) or self._mode
        return CommandResult(result=ACCEPTED)

    def offboard_setpoint(self, setpoint: OffboardSetpoint) -> None:
        """Take a setpoint of the offboard stream."""
        self._setpoint = setpoint

    @property
    def yaw_rad(self) -> float:
        """Heading now: what turns a setpoint in the body frame into NED."""
        return yaw_of(self._estimate.q_ned_frd) if self._estimate else 0.0

    def drain_texts(self) -> list[StatusText]:
        """Take the texts that came up since the last call."""
        texts, self._texts = self._texts, []
        return texts

    @property
    def status(self) -> VehicleStatus:
        """What the autopilot says about itself."""
        mode = self._mode
        e = self._estimate
        a, b, c, d = (
            900 if not self._armed else round(1000 + 1000 * m) for m in self._cascade.motors
        )
        return VehicleStatus(
            time_us=e.time_us if e else 0,
            mode=mode,
            intended_mode=mode,
            custom_mode=mode.custom_mode,
            base_mode=mode.value.base | BASE_ATTITUDE | (BASE_ARMED if self._armed else 0),
            system_status=4 if self._armed else 3,
            armed=self._armed,
            armable=True,
            failsafe=False,
            landed_state=1,
            home=self._home,
            home_ned=(0.0, 0.0, 0.0),
            home_valid=e is not None and e.position_valid,
            attitude_valid=e is not None and e.attitude_valid,
            position_valid=e is not None and e.position_valid,
            altitude_valid=e is not None and e.altitude_valid,
            throttle=self._cascade.asked.thrust,
            actuator_outputs=(a, b, c, d),
        )

    @property
    def setpoint_echo(self) -> SetpointEcho:
        """What the controllers follow now."""
        cascade = self._cascade
        asked = cascade.asked
        return SetpointEcho(
            time_us=self._estimate.time_us if self._estimate else 0,
            position_ned=cascade.setpoint.position_ned,
            velocity_ned=asked.velocity_ned,
            acceleration_ned=asked.acceleration_ned,
            yaw_rad=asked.yaw_rad,
            yaw_rate_rad_s=asked.yaw_rate_rad_s,
            q_ned_frd=asked.q_ned_frd,
            rates_frd=cascade.rates_frd,
            thrust=asked.thrust,
        )
