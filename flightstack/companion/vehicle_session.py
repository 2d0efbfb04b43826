"""Hold all that the companion exchanges with its vehicle over MAVLink in one hand."""

from pymavlink.dialects.v20 import common

from flightstack.companion.mission.records import MissionRequest
from flightstack.mavlink import commands
from flightstack.mavlink.clock.timesync import Timesync
from flightstack.mavlink.commands import CommandLong, CommandRefusal, CommandSender
from flightstack.mavlink.course_download import CourseDownload
from flightstack.mavlink.heartbeat import HeartbeatSender
from flightstack.mavlink.identity import VehicleIdentity
from flightstack.mavlink.link import Link, Message
from flightstack.mavlink.motion import MotionHistory
from flightstack.mavlink.offboard import Velocities, velocity_setpoint
from flightstack.mavlink.parameter_reader import ParameterReader
from flightstack.mavlink.telemetry import StatusText, Telemetry, TelemetryReceiver
from flightstack.mavlink.uncertainty import UncertaintyPublisher
from flightstack.px4_modes import Px4Mode
from flightstack.records import Decision, Image

TEXT_BYTES = 50  # of one STATUSTEXT
COURSE_ITEMS = (
    common.MAVLINK_MSG_ID_MISSION_COUNT,
    common.MAVLINK_MSG_ID_MISSION_ITEM_INT,
)


class VehicleSession:
    """The vehicle as the companion sees and addresses it; for one thread."""

    def __init__(
        self, link: Link, takeoff_altitude_m: float, *, publish_members: bool = False
    ) -> None:
        self.link = link
        self.setpoints = 0  # sent so far
        self.timesync = Timesync(link)
        self.parameters: ParameterReader | None = None  # where somebody wants to know some
        self._takeoff_altitude_m = takeoff_altitude_m
        self._receiver = TelemetryReceiver(link.clock)
        self._commands = CommandSender(link)
        self._heartbeat = HeartbeatSender(link.send, link.clock.wall_s)
        self._explanation: list[Message] = []  # of the setpoint that is to come
        self._uncertainty = UncertaintyPublisher(
            self._explanation.append, with_members=publish_members
        )
        self._download = CourseDownload(link)
        self._setpoint: Message | None = None
        self._refusals: list[CommandRefusal] = []
        self._restarts = 0  # of the vehicle, taken notice of

    @property
    def telemetry(self) -> Telemetry:
        """The newest view; a record that never changes."""
        return self._receiver.latest

    @property
    def motion(self) -> MotionHistory:
        """How the vehicle has moved, by its telemetry."""
        return self._receiver.motion

    @property
    def stream_uri(self) -> str | None:
        """Where the vehicle's camera says its stream is."""
        return self._receiver.stream_uri

    @property
    def stream_hz(self) -> float | None:
        """How many images a second the vehicle's camera says it gives."""
        return self._receiver.stream_hz

    def receive(self) -> None:
        """Take in all that has arrived."""
        messages = self.link.drain()
        if self.link.restarts != self._restarts:
            self._receiver.begin_anew()
            self.timesync.begin_anew()
        for message in messages:
            number = message.get_msgId()
            if number in COURSE_ITEMS:
                self._download.take(message)
            elif number == common.MAVLINK_MSG_ID_PARAM_VALUE and self.parameters is not None:
                self.parameters.take(message)
            elif number == common.MAVLINK_MSG_ID_TIMESYNC:
                self.timesync.take(message)
            elif number != common.MAVLINK_MSG_ID_COMMAND_ACK:
                self._receiver.update(message)
            elif refusal := self._commands.acknowledge(message):
                self._refusals.append(refusal)

    def turn_to(self, vehicle: VehicleIdentity) -> None:
        """Speak with this one, and forget all that another has said."""
        self.link.turn_to(vehicle)
        self._receiver.forget()
        self.timesync.begin_anew()
        self._commands = CommandSender(self.link)
        self._refusals.clear()

    def take_restart(self) -> int | None:
        """Return the last time before the vehicle restarted, where it has since the last call."""
        if self.link.restarts == self._restarts:
            return None
        self._restarts = self.link.restarts
        return self.link.clock.before_restart_us

    def lose_sight(self) -> None:
        """Forget the heartbeat of a vehicle that has fallen silent: the next one is news."""
        self._receiver.lose_sight()

    def drain_texts(self) -> list[StatusText]:
        """Return what the vehicle and its referee have said since the last call."""
        return self._receiver.drain_texts()

    def drain_refusals(self) -> list[CommandRefusal]:
        """Return the commands that were denied or never acknowledged since the last call."""
        refusals, self._refusals = self._refusals, []
        return refusals

    def request(self, request: MissionRequest, now_us: int) -> None:
        """Send the command that a request of the mission stands for."""
        self._commands.request(self._command(request), now_us)

    def abandon(self) -> None:
        """Ask for a landing with our last word; no answer is awaited."""
        self.request(MissionRequest.LAND, self.link.clock.stamp_us)

    def keep_up(self, now_us: int) -> None:
        """Send what is due: heartbeat, commands not acknowledged, questions for the time."""
        self._heartbeat.send_if_due(now_us)
        self._refusals += self._commands.poll(now_us)
        if self.timesync.wanted:
            self.timesync.poll()
        if self.parameters is not None:
            self.parameters.poll()

    def download_course(self, now_us: int) -> None:
        """Have the gates listed for the log, where there is a referee."""
        if self.telemetry.course.known:
            self._download.poll(now_us)

    def explain(self, decision: Decision, image: Image) -> None:
        """Have the next setpoint leave with how sure its decision is, and on how old an image."""
        self._uncertainty.publish(decision, image.stamp_us, image.age_s)

    def steer(self, velocities: Velocities, stamp_us: int) -> None:
        """Send the setpoint that answers the image of this stamp."""
        self._setpoint = velocity_setpoint(self.link.system_id, stamp_us, velocities)
        self.link.send(*self._explanation, self._setpoint)
        self._explanation.clear()
        self.setpoints += 1

    def repeat_setpoint(self) -> None:
        """Send the newest setpoint again, as it was; PX4 takes it for one more."""
        if self._setpoint is not None:
            self.link.send(self._setpoint)

    def announce(self, text: str) -> None:
        """Send a line for the people who watch the vehicle."""
        line = text.encode()[:TEXT_BYTES]
        self.link.send(common.MAVLink_statustext_message(common.MAV_SEVERITY_INFO, line))

    def _command(self, request: MissionRequest) -> CommandLong:
        if request is MissionRequest.TAKE_OFF:
            home_amsl_m = self.telemetry.home_altitude_amsl_m or 0.0  # known before arming
            return commands.take_off(home_amsl_m + self._takeoff_altitude_m)
        return COMMANDS[request]


COMMANDS = {
    MissionRequest.HOME_POSITION: commands.request_message(common.MAVLINK_MSG_ID_HOME_POSITION),
    MissionRequest.ARM: commands.arm(),
    MissionRequest.DISARM: commands.disarm(),
    MissionRequest.LAND: commands.land(),
    MissionRequest.HOLD_MODE: commands.set_mode(Px4Mode.LOITER),
    MissionRequest.OFFBOARD_MODE: commands.set_mode(Px4Mode.OFFBOARD),
}
