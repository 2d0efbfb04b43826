"""The autopilot: commander, navigator, take-off, land detector and cascade, a tick at a time."""

from collections.abc import Sequence

from sitl.autopilot.autopilot_parameters import AutopilotParameters
from sitl.autopilot.command.commander import Commander, ModeTransition
from sitl.autopilot.command.commands import Commands
from sitl.autopilot.command.failure_commands import FailureCommands
from sitl.autopilot.command.health_watch import HealthWatch
from sitl.autopilot.command.missions import Missions
from sitl.autopilot.command.mode_entry import ModeEntry
from sitl.autopilot.command.mode_table import Leader
from sitl.autopilot.command.report import report_setpoint, report_status
from sitl.autopilot.command.setpoints import ModeSetpoints
from sitl.autopilot.command.stick_override import StickOverride
from sitl.autopilot.control.cascade import Cascade
from sitl.autopilot.flight_modes.geofence import Geofence
from sitl.autopilot.flight_modes.home import Home
from sitl.autopilot.flight_modes.land_detector import LandDetector
from sitl.autopilot.flight_modes.manual import Manual
from sitl.autopilot.flight_modes.mission import MissionFlight
from sitl.autopilot.flight_modes.navigator import Navigator
from sitl.autopilot.flight_modes.offboard import OffboardStream
from sitl.autopilot.flight_modes.takeoff import Takeoff, TakeoffStage
from sitl.autopilot.parameters import Parameters
from sitl.frames import yaw_of
from sitl.records.failures import Failure
from sitl.records.motion import MotorThrusts, Vector3
from sitl.records.sensing import NO_ESTIMATE, Estimate
from sitl.records.texts import StatusText
from sitl.records.vehicle import (
    AttitudeTarget,
    Command,
    CommandResult,
    OffboardSetpoint,
    SetpointEcho,
    Sticks,
    VehicleStatus,
)

ORIGIN: Vector3 = (0.0, 0.0, 0.0)
IDLE_THRUST = 0.001  # what PX4 shows on the ground
LIFT_THRUST = 0.05  # assumption: attitude setpoints below this leave the vehicle on the ground


class Autopilot:
    """PX4-style flight control of one quadrotor, a pure function of what it is given.

    Time is that of the estimates. Commands and setpoints act at the next tick.
    """

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
        self._values = parameters.values
        p = AutopilotParameters.resolve(self._values)
        self._home = home
        self._home_place = Home()
        self._hover_thrust = hover_thrust
        self._estimate = NO_ESTIMATE
        self._airborne_pending = False
        self._clear = False  # flying, and once well above the ground
        self._cascade = Cascade(p.cascade, rotor_positions_frd_m, rotor_yaw_moments_m)
        self._offboard = OffboardStream(p.offboard)
        self._manual = Manual(p.manual)
        self._takeoff = Takeoff(p.takeoff)
        self._land_detector = LandDetector(p.land_detector)
        self._health = HealthWatch(p.health)
        commander = self._commander = Commander(p.commander, self._health)
        flight = self._mission_flight = MissionFlight(p.mission, home, commander.say)
        self._fence = Geofence(p.fence, home)
        missions = self.missions = Missions(
            p.plans, commander, self._health, flight, self._fence, home
        )
        navigator = self._navigator = Navigator(p.navigator, flight)
        self._entry = ModeEntry(p.entry, commander, navigator, missions, self._home_place, home[2])
        self._failures = FailureCommands(parameters, commander)
        self._commands = Commands(commander, missions, navigator, self._failures, home)
        self._stick_override = StickOverride(p.stick_override)
        self._setpoints = ModeSetpoints(
            commander, missions, navigator, self._offboard, self._manual
        )
        self._limits = p.limits

    def start_airborne(self) -> None:
        """Begin in the air, armed, in OFFBOARD, hovering: for training, never for a flight."""
        self._airborne_pending = self._clear = True
        self._home_place.start_airborne()
        self._commander.start_airborne()
        self._health.start_airborne()
        self._takeoff.start_airborne()
        self._land_detector.start_airborne()
        self._cascade.start_airborne(self._hover_thrust)

    def step(self, estimate: Estimate) -> MotorThrusts:
        """Advance by one tick of 4 ms and give the rotor thrusts for it."""
        self._estimate = estimate
        if self.parameters.values is not self._values:
            self._load()
        if self._airborne_pending:
            self._airborne_pending = False
            self._offboard.receive(
                OffboardSetpoint(time_us=estimate.time_us, velocity_ned=ORIGIN, yaw_rate_rad_s=0.0)
            )
        commander = self._commander
        just_armed = ModeTransition.ARMED in commander.transitions  # by a command
        if just_armed:  # perhaps in the same tick as it was disarmed
            self._takeoff.update(estimate.time_us, armed=False, landed=True, wants_climb=False)
            self._health.armed(estimate.time_us)
        landed = self._detect_landing(estimate)
        self._health.update(
            estimate,
            self._offboard,
            fence_breached=self._is_fence_breached(estimate),
            mission_available=self.missions.is_available,
            mission_failed=self._mission_flight.state.failed,
        )
        commander.update(estimate.time_us, landed=landed)
        home_request = self._commands.take_home_request()
        self._home_place.keep(estimate, home_request, just_armed=just_armed)
        if commander.take_transitions():
            flies = self._takeoff.state.stage is TakeoffStage.FLIGHT
            followed = self._cascade.state.attitude
            self._entry.begin(estimate, followed.acceleration_ned if flies else ORIGIN)
        if not commander.state.armed or commander.rules.is_final:
            self._takeoff.update(estimate.time_us, armed=False, landed=True, wants_climb=False)
            return self._cascade.stop(estimate)
        return self._fly(estimate, landed=landed)

    def command(self, command: Command) -> CommandResult | None:
        """Obey or refuse a MAVLink command; None where PX4 stays silent."""
        return self._commands.handle(command)

    def set_mode(self, main: int, sub: int) -> CommandResult:
        """Switch the mode, by PX4's numbers."""
        return self._commands.set_mode(main, sub)

    def offboard_setpoint(self, setpoint: OffboardSetpoint) -> None:
        """Take a setpoint of the offboard stream; OFFBOARD may be chosen right after it."""
        self._offboard.receive(setpoint)
        self._health.setpoint_heard(by_attitude=False)

    def attitude_setpoint(self, setpoint: AttitudeTarget) -> None:
        """Take a setpoint of the offboard stream that asks for an attitude or body rates."""
        self._offboard.receive_attitude(setpoint)
        self._health.setpoint_heard(by_attitude=True)

    def manual_control(self, sticks: Sticks) -> None:
        """Take the sticks' positions, if COM_RC_IN_MODE wants them from MAVLink."""
        if not self._health.parameters.links.takes_sticks:
            return
        self._health.sticks_heard(sticks.time_us)
        self._manual.receive(sticks)
        if self._stick_override.moves(sticks):
            self._stick_override.take_over(self._commander)

    def drain_texts(self) -> list[StatusText]:
        """Take the texts that came up since the last call."""
        return self._health.drain_texts() + self._commander.drain_texts()

    def drain_failures(self) -> list[Failure]:
        """Take the failures that were asked for since the last call."""
        return self._failures.drain()

    def ground_station_heard(self) -> None:
        """Note a ground station's heartbeat: its loss is a failsafe's matter."""
        self._health.ground_station_heard(self._estimate.time_us)

    def companion_heard(self) -> None:
        """Note a companion computer's heartbeat: its loss is told."""
        self._health.companion_heard(self._estimate.time_us)

    @property
    def armed(self) -> bool:
        """Whether the rotors may turn."""
        return self._commander.state.armed

    @property
    def yaw_rad(self) -> float:
        """Heading now: what turns a setpoint in the body frame into NED."""
        return yaw_of(self._estimate.q_ned_frd)

    @property
    def status(self) -> VehicleStatus:
        """What the autopilot says about itself."""
        return report_status(
            self._commander,
            self._cascade,
            self._estimate,
            home=self._home,
            home_ned=self._home_place.known_ned,
        )

    @property
    def setpoint_echo(self) -> SetpointEcho:
        """What the controllers follow now."""
        return report_setpoint(self._cascade, self._estimate.time_us)

    def _fly(self, estimate: Estimate, *, landed: bool) -> MotorThrusts:
        """Fly the mode, or stand on the ground with the rotors turning."""
        takeoff, rules = self._takeoff, self._commander.rules
        attitude = self._offboard.attitude if rules.leader is Leader.STREAM else None
        if attitude is not None:
            lifts = attitude.thrust > LIFT_THRUST
            stage = takeoff.update_by_thrust(estimate.time_us, landed=landed, lifts=lifts)
            if stage is TakeoffStage.FLIGHT:
                return self._cascade.fly_attitude(estimate, attitude, landed=landed)
            return self._cascade.idle(estimate, IDLE_THRUST)
        flying = takeoff.state.stage is TakeoffStage.FLIGHT
        climbs = self._setpoints.wants_climb(estimate, landed=landed, flying=flying)
        stage = takeoff.update(estimate.time_us, armed=True, landed=landed, wants_climb=climbs)
        in_flight = stage is TakeoffStage.FLIGHT
        self._clear = in_flight and (self._clear or self._home_place.is_clear_of_ground(estimate))
        if not (in_flight or stage is TakeoffStage.RAMP_UP) or (
            in_flight and self._land_detector.state.ground_contact
        ):
            return self._cascade.idle(estimate, IDLE_THRUST)
        limits = self._limits.flight
        if not in_flight:
            by_itself = rules.takes_off
            speed_up = self._limits.takeoff_speed_m_s if by_itself else limits.speed_up_m_s
            speed_up = takeoff.speed_limit(estimate.time_us, speed_up)
            limits = self._limits.takeoff._replace(speed_up_m_s=speed_up)
        setpoint = self._setpoints.now(estimate, in_flight=in_flight)
        return self._cascade.fly(estimate, setpoint, limits, landed=landed, clear=self._clear)

    def _detect_landing(self, estimate: Estimate) -> bool:
        detector, commander = self._land_detector, self._commander
        rules, followed = commander.rules, self._cascade.state.attitude
        # Where thrust is asked for directly, only its size tells a descent.
        by_thrust = rules.leader is Leader.STREAM and self._offboard.attitude is not None
        falls = rules.is_final or by_thrust
        return detector.update(
            estimate,
            armed=commander.state.armed,
            descending=falls or followed.velocity_ned[2] >= detector.parameters.descent_min_m_s,
            thrust=followed.thrust,
        )

    def _is_fence_breached(self, estimate: Estimate) -> bool:
        home = self._home_place.known_ned
        if home is None or not estimate.position_valid:
            return False
        return self.missions.watch(estimate, home)

    def _load(self) -> None:
        """Hand changed parameters on, as a new record to every part."""
        self._values = self.parameters.values
        p = AutopilotParameters.resolve(self._values)
        self._health.parameters = p.health
        self._commander.parameters = p.commander
        self.missions.parameters = p.plans
        self._entry.parameters = p.entry
        self._stick_override.parameters = p.stick_override
        self._fence.parameters = p.fence
        self._mission_flight.parameters = p.mission
        self._navigator.parameters = p.navigator
        self._offboard.parameters = p.offboard
        self._manual.parameters = p.manual
        self._takeoff.parameters = p.takeoff
        self._land_detector.parameters = p.land_detector
        self._cascade.parameters = p.cascade
        self._limits = p.limits
        self.missions.judge_mission()
        self._health.judge_battery()
