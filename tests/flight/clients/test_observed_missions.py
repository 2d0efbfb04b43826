"""What a real PX4 was seen answering about missions, line by line, from the running vehicle."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from pymavlink.dialects.v20 import common as mavlink

from flightstack.launch.instances import free_instance
from tests.flight.clients.observer import Observer
from tests.flight.processes import process

pytestmark = pytest.mark.flight
NAN = math.nan
ARM, SET_MODE = 400, 176
LATITUDE_E7, LONGITUDE_E7 = 473977420, 85455940
ANSWERS = {
    "MISSION_REQUEST_INT",
    "MISSION_REQUEST",
    "MISSION_ACK",
    "MISSION_COUNT",
    "MISSION_ITEM_INT",
    "MISSION_ITEM",
    "STATUSTEXT",
}
SOON_S, SLOW_S = 5.0, 30.0


class Conversation:
    """A ground station that says one thing and hears what comes of it."""

    def __init__(self, observer: Observer, system: int) -> None:
        self.observer = observer
        self.system = system
        self._pings = 1000

    def ask(self, message: Any) -> list[Any]:
        """Answers of the autopilot to a message: all that comes before that to a later ping."""
        self._pings += 1
        heard: list[Any] = []

        def is_pong(received: Any) -> bool:
            name = received.get_type()
            if received.get_srcComponent() == 1 and name in ANSWERS:
                heard.append(received)
            return bool(name == "PING" and received.seq == self._pings)

        self.observer.send(message)
        self.observer.send(mavlink.MAVLink_ping_message(0, self._pings, 0, 0))
        self.observer.wait_for(is_pong, "answer to the ping", timeout_s=SOON_S)
        return heard

    def command(self, number: int, *params: float) -> None:
        filled = [*params, *[0.0] * (7 - len(params))]
        self.observer.send(mavlink.MAVLink_command_long_message(self.system, 1, number, 0, *filled))


def is_ready(message: Any) -> bool:
    if message.get_type() != "SYS_STATUS":
        return False
    return bool(message.onboard_control_sensors_health & mavlink.MAV_SYS_STATUS_PREARM_CHECK)


@pytest.fixture
def talk(tmp_path: Path) -> Iterator[Conversation]:
    with free_instance() as instance:
        options = (f"--instance={instance}", "--noise=0,0", "--speed-factor=5")
        with (
            process("sitl", *options, log=tmp_path / "vehicle.txt"),
            Observer(instance) as observer,
        ):
            observer.wait_for(is_ready, "readiness", timeout_s=20.0)
            yield Conversation(observer, system=instance + 1)


def item(system: int, sequence: int, command: int = 16, height_m: float = 5.0) -> Any:
    numbers = (0.0, 2.0, 0.0, NAN, LATITUDE_E7 + 300 * sequence, LONGITUDE_E7, height_m)
    head = (system, 1, sequence, 6, command, int(sequence == 0), 1)
    return mavlink.MAVLink_mission_item_int_message(*head, *numbers)


def brief(message: Any) -> tuple[Any, ...]:
    """The name, and what there is to say."""
    fields = ("seq", "count", "type", "mission_type", "text")
    return (message.get_type(), *(getattr(message, f) for f in fields if hasattr(message, f)))


def test_the_protocol(talk: Conversation) -> None:
    me, m = talk.system, mavlink

    def count(number: int, system: int = me) -> Any:
        return m.MAVLink_mission_count_message(system, 1, number, 0)

    def listing(kind: int) -> Any:
        return m.MAVLink_mission_request_list_message(me, 1, kind)

    def request(sequence: int) -> Any:
        return m.MAVLink_mission_request_int_message(me, 1, sequence, 0)

    clear = m.MAVLink_mission_clear_all_message(me, 1, 0)
    table = [
        *((listing(kind), [("MISSION_COUNT", 0, kind)]) for kind in (0, 1, 2)),
        (request(99), []),
        (count(3, me % 255 + 1), []),  # another system's
        (count(3), [("MISSION_REQUEST_INT", 0, 0)]),
        (item(me, 0), [("MISSION_REQUEST_INT", 1, 0)]),
        (item(me, 1), [("MISSION_REQUEST_INT", 2, 0)]),
        (item(me, 2), [("MISSION_ACK", 0, 0)]),
        (count(1), [("MISSION_REQUEST_INT", 0, 0)]),
        (item(me, 0, command=9999), [("MISSION_ACK", 3, 0)]),  # and no text
        (listing(0), [("MISSION_COUNT", 3, 0)]),
        *((request(n), [("MISSION_ITEM_INT", n, 0)]) for n in range(3)),
        (m.MAVLink_mission_ack_message(me, 1, 0, 0), []),
        (request(99), []),
        (clear, [("MISSION_ACK", 0, 0)]),
        (listing(0), [("MISSION_COUNT", 0, 0)]),
    ]
    for number, (message, expected) in enumerate(table):
        assert [brief(heard) for heard in talk.ask(message)] == expected, (number, str(message))


def test_what_is_given_back_and_the_current_item(talk: Conversation) -> None:
    sent = [item(talk.system, n) for n in range(3)]
    _upload(talk, sent)
    talk.ask(mavlink.MAVLink_mission_request_list_message(talk.system, 1, 0))
    for number, expected in enumerate(sent):
        (got,) = talk.ask(mavlink.MAVLink_mission_request_int_message(talk.system, 1, number, 0))
        assert math.isnan(got.param4)
        assert (got.frame, got.current) == (6, int(number == 0))
        assert (got.x, got.y, got.z) == (expected.x, expected.y, expected.z)

    def is_current(message: Any, **fields: int) -> bool:
        ours = message.get_type() == "MISSION_CURRENT" and message.get_srcComponent() == 1
        return ours and all(getattr(message, name) == value for name, value in fields.items())

    def wait(**fields: int) -> None:
        what = f"MISSION_CURRENT {fields}"
        talk.observer.wait_for(
            lambda message: is_current(message, **fields), what, timeout_s=SOON_S
        )

    wait(seq=0, total=3, mission_state=2, mission_mode=2)
    talk.observer.send(mavlink.MAVLink_mission_set_current_message(talk.system, 1, 2))
    wait(seq=2, total=3)
    talk.ask(mavlink.MAVLink_mission_clear_all_message(talk.system, 1, 0))
    wait(seq=0, total=65535, mission_state=1, mission_mode=2)


def test_chosen_while_disarmed_and_flown_once_armed(talk: Conversation) -> None:
    _upload(talk, [item(talk.system, 0, command=22), item(talk.system, 1)])
    talk.command(SET_MODE, 1.0, 4.0, 4.0)
    talk.observer.wait_for_mode(0x04040000, armed=False, timeout_s=SOON_S)
    talk.command(ARM, 1.0)
    for text in (
        "Armed by external command\t",
        "Executing Mission\t",
        "Climb to 5.0 meters above home\t",
        "Takeoff detected\t",
        "Mission finished, loitering\t",
    ):
        said = talk.observer.wait_for_text(text, timeout_s=SLOW_S)
        assert said.severity == 6


def _upload(talk: Conversation, items: list[Any]) -> None:
    talk.ask(mavlink.MAVLink_mission_count_message(talk.system, 1, len(items), 0))
    answers = [brief(heard) for message in items for heard in talk.ask(message)]
    assert answers[-1] == ("MISSION_ACK", 0, 0)
