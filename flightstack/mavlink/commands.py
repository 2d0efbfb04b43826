"""Send commands to the vehicle, again until they are acknowledged.

Commands of PX4 are idempotent, so that sending one twice does no harm. An acknowledgement says
that a command was taken, not that it has had its effect: modes and arming show in HEARTBEAT.
"""

import math
from dataclasses import dataclass

from pymavlink.dialects.v20 import common

from flightstack.mavlink.link import Link, Message
from flightstack.mavlink_numbers import AUTOPILOT_COMPONENT, COMPANION_COMPONENT
from flightstack.px4_modes import Px4Mode

RETRY_US = 500_000  # PX4 and MAVSDK wait as long
ATTEMPTS = 4  # PX4 and MAVSDK: three retries
TAKEN = (common.MAV_RESULT_ACCEPTED, common.MAV_RESULT_IN_PROGRESS)
NAN = math.nan  # a parameter of a command that leaves the choice to the vehicle


@dataclass(frozen=True, slots=True, kw_only=True)
class CommandLong:
    """A COMMAND_LONG: its number, its seven parameters, and the component it is for."""

    number: int
    params: tuple[float, float, float, float, float, float, float]
    component: int = AUTOPILOT_COMPONENT


@dataclass(frozen=True, slots=True)
class CommandRefusal:
    """A command that was denied, or that nobody acknowledged."""

    command: CommandLong
    reason: str


@dataclass(frozen=True, slots=True)
class _Pending:
    command: CommandLong
    attempts: int
    sent_us: int


class CommandSender:
    """Keep one command of a kind in flight for each component; `now_us` is the caller's clock."""

    def __init__(self, link: Link) -> None:
        self._link = link
        self._pending: dict[tuple[int, int], _Pending] = {}
        self._last: dict[tuple[int, int], CommandLong] = {}

    def request(self, command: CommandLong, now_us: int) -> None:
        """Send a command; a pending one of the same kind is forgotten."""
        self._transmit(_Pending(command, 1, now_us))

    def acknowledge(self, ack: Message) -> CommandRefusal | None:
        """Take a COMMAND_ACK; return the refusal that it may be.

        PX4 acknowledges DO_SET_MODE twice, and may refuse it only in the second.
        """
        if ack.target_component not in (0, COMPANION_COMPONENT):
            return None
        key = (ack.get_srcComponent(), ack.command)
        self._pending.pop(key, None)
        command = self._last.get(key)
        if command is None or ack.result in TAKEN:
            return None
        return CommandRefusal(command, _result_name(ack.result))

    def poll(self, now_us: int) -> list[CommandRefusal]:
        """Send again what is overdue; return what nobody acknowledged in all its attempts."""
        given_up = []
        for key, pending in list(self._pending.items()):
            if now_us - pending.sent_us < RETRY_US:
                continue
            if pending.attempts >= ATTEMPTS:
                del self._pending[key]
                given_up.append(CommandRefusal(pending.command, "not acknowledged"))
            else:
                self._transmit(_Pending(pending.command, pending.attempts + 1, now_us))
        return given_up

    def _transmit(self, pending: _Pending) -> None:
        command = pending.command
        key = (command.component, command.number)
        self._pending[key] = pending
        self._last[key] = command
        self._link.send(
            common.MAVLink_command_long_message(
                self._link.system_id,
                command.component,
                command.number,
                pending.attempts - 1,
                *command.params,
            )
        )


def arm() -> CommandLong:
    """Start the motors, if the vehicle's own checks agree."""
    return CommandLong(number=common.MAV_CMD_COMPONENT_ARM_DISARM, params=(1, 0, 0, 0, 0, 0, 0))


def disarm() -> CommandLong:
    """Stop the motors; a vehicle in the air refuses."""
    return CommandLong(number=common.MAV_CMD_COMPONENT_ARM_DISARM, params=(0, 0, 0, 0, 0, 0, 0))


def take_off(altitude_amsl_m: float) -> CommandLong:
    """Climb from here to an altitude above mean sea level, and hold there."""
    params = (0.0, 0.0, 0.0, NAN, NAN, NAN, altitude_amsl_m)
    return CommandLong(number=common.MAV_CMD_NAV_TAKEOFF, params=params)


def land() -> CommandLong:
    """Land here."""
    return CommandLong(number=common.MAV_CMD_NAV_LAND, params=(0.0, 0.0, 0.0, NAN, NAN, NAN, 0.0))


def set_mode(mode: Px4Mode) -> CommandLong:
    """Switch the flight mode."""
    custom = float(common.MAV_MODE_FLAG_CUSTOM_MODE_ENABLED)
    params = (custom, float(mode.main), float(mode.sub), 0.0, 0.0, 0.0, 0.0)
    return CommandLong(number=common.MAV_CMD_DO_SET_MODE, params=params)


def request_message(number: int, component: int = AUTOPILOT_COMPONENT) -> CommandLong:
    """Ask a component for one message."""
    return CommandLong(
        number=common.MAV_CMD_REQUEST_MESSAGE,
        params=(float(number), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        component=component,
    )


def command_name(command: CommandLong) -> str:
    """Name a command for people, as MAVLink does."""
    entry = common.enums["MAV_CMD"].get(command.number)
    return entry.name.removeprefix("MAV_CMD_") if entry else f"command {command.number}"


def _result_name(result: int) -> str:
    entry = common.enums["MAV_RESULT"].get(result)
    return entry.name.removeprefix("MAV_RESULT_").lower() if entry else f"result {result}"
