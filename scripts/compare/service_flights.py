"""Scripts that ask a vehicle for all it serves: parameters, files, logs, messages, commands."""

import struct
from collections.abc import Callable

from pymavlink.dialects.v20 import development as mavlink

from scripts.compare.messages import Message
from scripts.compare.pilot import REQUEST_MESSAGE, SET_MESSAGE_INTERVAL, Pilot, ScriptedFlight
from scripts.compare.words import NAN, RALLY, Item, command, parameter

COUNT, ITEM, PARAMETER, FILE, PONG = 44, 73, 22, 110, mavlink.MAVLINK_MSG_ID_PING
LOG_ENTRY, LOG_DATA = mavlink.MAVLINK_MSG_ID_LOG_ENTRY, mavlink.MAVLINK_MSG_ID_LOG_DATA
GET_MESSAGE_INTERVAL, ARM = 510, 400
COMPONENTS = (1, 25, 100)
END, RESET, LIST, OPEN, READ, CHECKSUM, BURST, REMOVE = 1, 2, 3, 4, 5, 14, 15, 8
FILE_HEADER = struct.Struct("<HBBBBBBI")
FILE_BYTES, LOG_BYTES = 239, 90
UNKNOWN_MESSAGES = (0xFFFF, 300, 397, 410, 435)


def _parameters(pilot: Pilot) -> None:
    pilot.fly(0.1)
    pilot.say(mavlink.MAVLink_param_request_list_message(1, 1))
    pilot.ask(mavlink.MAVLink_ping_message(0, 1, 0, 0), PONG)
    count = pilot.hear(lambda m: m.kind == PARAMETER).fields()["param_count"]
    pilot.hear(_is_parameter(count - 1))
    for index in range(count):
        pilot.say(mavlink.MAVLink_param_request_read_message(1, 1, b"", index))
        pilot.fly(0.05)
    for asked in (b"_HASH_CHECK", b"MPC_XY_P", b"NOT_THERE"):
        pilot.fly(0.05, mavlink.MAVLink_param_request_read_message(1, 1, asked, -1))
    for name, value in (("COM_FAIL_ACT_T", 99.0), ("NAV_DLL_ACT", 2.0), ("GF_ACTION", 77)):
        pilot.fly(0.05, parameter(name, value))
    pilot.fly(0.5)


def _is_parameter(index: int) -> Callable[[Message], bool]:
    return lambda m: m.kind == PARAMETER and m.fields()["param_index"] == index


class _Files:
    """A client of the file transfer, one question at a time."""

    def __init__(self, pilot: Pilot) -> None:
        self._pilot = pilot
        self._sequence = 0

    def ask(self, opcode: int, data: bytes = b"", session: int = 0, offset: int = 0) -> bytes:
        """Ask, and give the answer's payload."""
        size = len(data) or (FILE_BYTES if opcode in (READ, BURST) else 0)
        header = FILE_HEADER.pack(self._sequence, session, opcode, size, 0, 0, 0, offset)
        payload = list((header + data).ljust(251, b"\0"))
        self._sequence += 1
        question = mavlink.MAVLink_file_transfer_protocol_message(0, 1, 1, payload)
        return bytes(self._pilot.ask(question, FILE).fields()["payload"])

    def fetch(self, path: bytes) -> None:
        """Read a whole file."""
        opened = self.ask(OPEN, path)
        session, size = opened[2], struct.unpack_from("<I", opened, 12)[0]
        for offset in range(0, size, FILE_BYTES):
            self.ask(READ, session=session, offset=offset)
        self.ask(END, session=session)


def _files(pilot: Pilot) -> None:
    pilot.fly(1.2)
    files = _Files(pilot)
    files.ask(RESET)
    for path in (b"/", b"/log", b"/nowhere"):
        files.ask(LIST, path)
    for path in (b"/general.json", b"/parameters.json"):
        files.fetch(path)
        files.ask(CHECKSUM, path)
    for path in (b"/nowhere", b"../../etc", b"/log"):
        files.ask(OPEN, path)
    files.ask(REMOVE, b"/general.json")
    session = files.ask(OPEN, b"/parameters.json")[2]
    files.ask(BURST, session=session)
    pilot.hear(lambda m: m.kind == FILE and bool(m.fields()["payload"][6]))  # burst complete
    files.ask(END, session=session)
    pilot.fly(0.2)


def _logs(pilot: Pilot) -> None:
    pilot.fly(1.5)
    pilot.ask(mavlink.MAVLink_log_request_list_message(1, 1, 0, 0xFFFF), LOG_ENTRY)
    pilot.fly(2.0, command(ARM, 1.0))
    pilot.fly(1.0, command(ARM, 0.0))
    entry = pilot.ask(mavlink.MAVLink_log_request_list_message(1, 1, 0, 0xFFFF), LOG_ENTRY)
    size = min(20 * LOG_BYTES, entry.fields()["size"])
    number = entry.fields()["id"]
    pilot.ask(mavlink.MAVLink_log_request_data_message(1, 1, number, 0, size), LOG_DATA)
    pilot.hear(lambda m: m.kind == LOG_DATA and m.fields()["ofs"] == size - LOG_BYTES)
    pilot.fly(0.2, mavlink.MAVLink_log_request_end_message(1, 1))
    pilot.fly(0.2, mavlink.MAVLink_log_erase_message(1, 1))


def _requests(pilot: Pilot) -> None:
    pilot.fly(1.5)
    kinds = sorted({*mavlink.mavlink_map, *UNKNOWN_MESSAGES})
    for kind in kinds:
        pilot.say(*(command(REQUEST_MESSAGE, float(kind), component=c) for c in COMPONENTS))
        pilot.fly(0.05, command(GET_MESSAGE_INTERVAL, float(kind)))
    for index in range(1, 20):
        pilot.fly(0.05, command(REQUEST_MESSAGE, 435.0, float(index)))  # AVAILABLE_MODES
    for kind in kinds:
        pilot.fly(0.05, command(SET_MESSAGE_INTERVAL, float(kind), 150_000.0))
    pilot.fly(1.0)
    for interval_us in (-1.0, 0.0, 1.0, NAN):
        pilot.fly(0.5, command(SET_MESSAGE_INTERVAL, 30.0, interval_us))


def _commands(pilot: Pilot) -> None:
    pilot.fly(1.5)
    for number in sorted(mavlink.enums["MAV_CMD"]):
        if number <= 0xFFFF:
            pilot.say(command(number), command(number, *[1.0] * 7, component=100))
            pilot.say(command(number, *[NAN] * 7))
            numbers = (0, 0, *[0.0] * 4, 0, 0, 0.0)
            pilot.fly(0.05, mavlink.MAVLink_command_int_message(1, 0, 6, number, *numbers))
    pilot.fly(0.5, command(ARM, 1.0), command(ARM, 2.0))
    pilot.fly(11.5)  # disarmed by itself


def _plans(pilot: Pilot) -> None:
    pilot.fly(0.1)
    pilot.upload(RALLY, Item(5100, north_m=5.0), Item(5100, east_m=5.0))
    for component, kind in ((1, 0), (1, 1), (1, 2), (1, 7), (25, 0), (25, 1)):
        request = mavlink.MAVLink_mission_request_list_message(1, component, kind)
        answer = pilot.ask(request, COUNT, mavlink.MAVLINK_MSG_ID_MISSION_ACK)
        for index in range(answer.fields().get("count", 0)):
            item = mavlink.MAVLink_mission_request_int_message(1, component, index, kind)
            pilot.ask(item, ITEM)
        pilot.fly(0.1, mavlink.MAVLink_mission_request_message(1, component, 0, kind))
        pilot.fly(0.1, mavlink.MAVLink_mission_ack_message(1, component, 0, kind))
    pilot.fly(0.5, mavlink.MAVLink_mission_set_current_message(1, 1, 9))


def _small_questions(pilot: Pilot) -> None:
    pilot.fly(1.0)
    pilot.fly(0.1, mavlink.MAVLink_timesync_message(0, 77), mavlink.MAVLink_timesync_message(5, 7))
    pilot.fly(0.1, mavlink.MAVLink_ping_message(0, 3, 0, 0))
    pilot.fly(0.1, mavlink.MAVLink_system_time_message(10**15, 5))
    pilot.fly(1.0, command(179, 0.0, 0.0, 0.0, NAN, 47.398, 8.546, 480.0))
    pilot.fly(1.0, command(179, 1.0))
    pilot.fly(2.0, mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3))


SERVICE_FLIGHTS = {
    "serve-parameters": ScriptedFlight(_parameters),
    "serve-files": ScriptedFlight(_files),
    "serve-logs": ScriptedFlight(_logs),
    "serve-requests": ScriptedFlight(_requests),
    "serve-commands": ScriptedFlight(_commands),
    "serve-plans": ScriptedFlight(_plans),
    "serve-small-questions": ScriptedFlight(_small_questions),
}
