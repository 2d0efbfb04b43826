"""QGroundControl's connect sequence, step by step: every question gets an answer.

The steps and their order are those of its initial connect: who are you, which modes, metadata by
file transfer, parameters, mission, geofence, rally points, and the events and camera questions
that come in between.
"""

import json
import struct
from collections.abc import Iterator
from typing import Any

import pytest
from pymavlink.dialects.v20 import development as mavlink

from sitl.mavlink.wire import newer_messages
from tests.observed.parameters import NEEDED
from tests.wire.vehicle_process import Client, Vehicle, is_acknowledgement, is_from

pytestmark = pytest.mark.flight
REQUEST_MESSAGE, ACCEPTED = 512, 0
PROTOCOL_VERSION = 300  # which pymavlink leaves out
HASH_CHECK = "_HASH_CHECK"
NEEDED_CAPABILITIES = (
    *("MISSION_FLOAT", "MISSION_INT", "PARAM_FLOAT", "COMMAND_INT", "PARAM_ENCODE_BYTEWISE"),
    *("FTP", "SET_POSITION_TARGET_LOCAL_NED", "FLIGHT_TERMINATION", "MAVLINK2"),
    *("MISSION_FENCE", "MISSION_RALLY"),
)


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    with Vehicle() as vehicle:
        vehicle.wait_until_up()
        vehicle.gcs.say_hello()
        yield vehicle.gcs


def request(client: Client, message_id: int, parameter: float = 0.0, component: int = 1) -> Any:
    """Ask for a message as it does; the answer and its acknowledgement, which comes after."""
    client.forget()
    client.command(REQUEST_MESSAGE, message_id, parameter, target=(1, component))
    name = mavlink.mavlink_map[message_id].msgname
    answer = client.wait_for(lambda m: m.get_type() == name and m.get_srcComponent() == component)
    assert client.wait_for(is_acknowledgement(REQUEST_MESSAGE)).result == ACCEPTED
    return answer


class Files:
    """File transfer, one question at a time."""

    def __init__(self, client: Client) -> None:
        self.client = client
        self.sequence = 0

    def ask(self, opcode: int, data: bytes = b"", session: int = 0, offset: int = 0) -> bytes:
        size = len(data) or (239 if opcode == 15 else 0)
        header = struct.pack("<HBBBBBBI", self.sequence, session, opcode, size, 0, 0, 0, offset)
        payload = list((header + data).ljust(251, b"\0"))
        self.client.send(mavlink.MAVLink_file_transfer_protocol_message(0, 1, 1, payload))
        self.sequence += 1
        answer = self.client.wait_for("FILE_TRANSFER_PROTOCOL")
        return bytes(answer.payload)

    def fetch(self, uri: str) -> Any:
        assert self.ask(2)[3] == 128  # reset sessions
        opened = self.ask(4, uri.removeprefix("mftp://").encode())
        assert opened[3] == 128
        session, size = opened[2], struct.unpack_from("<I", opened, 12)[0]
        content = b""
        while len(content) < size:
            piece = self.ask(5, b"\0" * 239, session, len(content))
            assert piece[3] == 128
            content += piece[12 : 12 + piece[4]]
        assert self.ask(1, session=session)[3] == 128
        return json.loads(content)


def test_first_it_asks_who_the_vehicle_is(client: Client) -> None:
    beat = client.wait_for(is_from(1, "HEARTBEAT"))
    assert (beat.type, beat.autopilot) == (2, 12)
    version = request(client, mavlink.MAVLINK_MSG_ID_AUTOPILOT_VERSION)
    assert version.flight_sw_version >> 24 == 1
    assert version.flight_sw_version & 0xFF == 255
    for name in NEEDED_CAPABILITIES:
        assert version.capabilities & getattr(mavlink, f"MAV_PROTOCOL_CAPABILITY_{name}"), name
    client.command(REQUEST_MESSAGE, PROTOCOL_VERSION)
    assert client.wait_for(is_acknowledgement(REQUEST_MESSAGE)).result == ACCEPTED


def test_then_which_modes_there_are(client: Client) -> None:
    first = request(client, mavlink.MAVLINK_MSG_ID_AVAILABLE_MODES, 1)
    count = first.number_modes
    modes = [first] + [
        request(client, mavlink.MAVLINK_MSG_ID_AVAILABLE_MODES, number)
        for number in range(2, count + 1)
    ]
    assert [mode.mode_index for mode in modes] == list(range(1, count + 1))
    assert len({mode.custom_mode for mode in modes}) == count > 5
    assert all(mode.standard_mode or mode.mode_name for mode in modes)


def test_then_the_metadata_by_file_transfer(client: Client) -> None:
    metadata = request(client, newer_messages.ComponentMetadata.id)
    uri = metadata.uri.decode()
    files = Files(client)
    general = files.fetch(uri)
    (described,) = general["metadataTypes"]
    parameters = files.fetch(described["uri"])["parameters"]
    assert {"COM_OF_LOSS_T", "MPC_XY_VEL_MAX"} <= {row["name"] for row in parameters}


def test_then_all_parameters(client: Client) -> None:
    client.forget()
    client.send(mavlink.MAVLink_param_request_list_message(1, 1))
    names: dict[str, int] = {}
    for message in client.messages():
        if message.get_type() == "PARAM_VALUE":
            names[message.param_id] = message.param_index
            if len(names) > message.param_count:
                break
    assert names.pop(HASH_CHECK) == 65535
    assert sorted(names.values()) == list(range(len(names)))
    assert not NEEDED - set(names)


@pytest.mark.parametrize("kind", [0, 1, 2], ids=["mission", "geofence", "rally points"])
def test_then_each_plan(client: Client, kind: int) -> None:
    client.send(mavlink.MAVLink_mission_request_list_message(1, 1, kind))
    count = client.wait_for("MISSION_COUNT")
    assert (count.count, count.mission_type) == (0, kind)
    client.send(mavlink.MAVLink_mission_ack_message(1, 1, 0, kind))


def test_events_that_are_asked_for_are_answered(client: Client) -> None:
    sequence = client.wait_for("CURRENT_EVENT_SEQUENCE")
    assert (sequence.sequence, sequence.flags) == (0, 1)
    client.send(newer_messages.RequestEvent(0, 0, 1, 1))
    assert client.wait_for("RESPONSE_EVENT_ERROR").target_system == 42


@pytest.mark.parametrize(
    "message_id",
    [
        mavlink.MAVLINK_MSG_ID_CAMERA_INFORMATION,
        mavlink.MAVLINK_MSG_ID_CAMERA_SETTINGS,
        mavlink.MAVLINK_MSG_ID_VIDEO_STREAM_INFORMATION,
    ],
)
def test_the_camera_says_what_it_is(client: Client, message_id: int) -> None:
    assert request(client, message_id, component=100) is not None


@pytest.mark.parametrize("message_id", [259, 395, 9999])
def test_what_the_autopilot_has_not_is_denied_at_once(client: Client, message_id: int) -> None:
    client.forget()
    client.command(REQUEST_MESSAGE, message_id)
    assert client.wait_for(is_acknowledgement(REQUEST_MESSAGE), timeout_s=2.0).result == 2


def test_home_and_the_older_questions_are_answered(client: Client) -> None:
    assert request(client, mavlink.MAVLINK_MSG_ID_HOME_POSITION).latitude != 0
    client.command(520, 1)
    client.wait_for("AUTOPILOT_VERSION")
    assert client.wait_for(is_acknowledgement(520)).result == ACCEPTED
    client.send(mavlink.MAVLink_log_request_list_message(1, 1, 0, 0xFFFF))
    assert client.wait_for("LOG_ENTRY").num_logs == 0
