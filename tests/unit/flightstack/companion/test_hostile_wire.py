"""No packet, whatever stands in its fields, and no stamp of an image ends a flight by exception."""

import random
import struct
from pathlib import Path

import pytest
from pymavlink.dialects.v20 import common

from flightstack.companion.console import Console
from flightstack.companion.mission.records import MissionPhase
from flightstack.companion.reporter import Reporter
from flightstack.mavlink.packets import checksum
from flightstack.mavlink.telemetry import LandedState
from tests.unit.flightstack.companion.made_flight import MadeFlight, forward_m_s

FIELDS = (b"\x00", b"\xff", b"\x7f", b"\x80", struct.pack("<f", float("nan")), b"\x00\x00\x80\x7f")
COMPONENTS = (1, 1, 1, 25, 100)
CHEATS = 20_000


@pytest.fixture
def flight(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> MadeFlight:
    return MadeFlight(tmp_path, monkeypatch)


def any_packet(rng: random.Random) -> bytes:
    """Any message of the dialect, sound to the last bit, with anything in its fields."""
    number = rng.choice(list(common.mavlink_map))
    kind = common.mavlink_map[number]
    size = rng.choice((kind.unpacker.size, rng.randrange(256)))
    payload = (rng.choice(FIELDS) * 256)[:size] if rng.random() < 0.5 else rng.randbytes(size)
    if number < 256 and rng.random() < 0.3:
        head = struct.pack("<BBBBBB", 0xFE, size, 0, 3, rng.choice(COMPONENTS), number)
    else:
        ids = (3, rng.choice(COMPONENTS), number & 0xFFFF, number >> 16)
        head = struct.pack("<BBBBBBBHB", 0xFD, size, 0, 0, 0, *ids)
    return head + payload + struct.pack("<H", checksum(head + payload))


def test_no_packet_of_any_content_raises(flight: MadeFlight) -> None:
    rng = random.Random(18)  # noqa: S311  (no secret)
    flight.loop._reporter = Reporter(Console(verbosity=-2))
    for _ in range(CHEATS // 20):
        for _ in range(20):
            flight.made.hear(any_packet(rng))
        if rng.random() < 0.5:
            flight.show(rng.randrange(2**42))
        flight.made.wall.now_s += 0.02
        flight.loop._turn()
    assert flight.sent()  # it still speaks, and hears
    flight.made.say(common.MAVLink_extended_sys_state_message(0, common.MAV_LANDED_STATE_IN_AIR))
    flight.turn(50)
    assert flight.session.telemetry.landed is LandedState.IN_AIR


@pytest.mark.parametrize("value", [5, 77, 255])
def test_a_landed_state_that_nobody_knows_is_unknown(flight: MadeFlight, value: int) -> None:
    flight.made.say(common.MAVLink_extended_sys_state_message(0, value))
    flight.turn(50)
    assert flight.session.telemetry.landed is LandedState.UNKNOWN


@pytest.mark.parametrize("value", [float("nan"), float("inf"), -float("inf")])
def test_a_speed_that_is_no_number_is_not_known(flight: MadeFlight, value: float) -> None:
    flight.made.say(common.MAVLink_local_position_ned_message(0, 0, value, 0, value, 0, 0))
    flight.turn(50)
    assert flight.session.telemetry.velocity_ned is flight.session.telemetry.position_ned is None


def test_texts_without_end_are_forgotten(flight: MadeFlight) -> None:
    for chunk in range(2000):
        text = b"x" * 50
        flight.made.say(common.MAVLink_statustext_message(6, text, chunk % 500 + 1, chunk % 256))
    flight.session.receive()
    receiver = flight.session._receiver
    assert sum(map(len, receiver._chunks.values())) < 16 * 50 * 5
    for chunk in range(600):
        flight.made.say(common.MAVLink_statustext_message(6, b"x" * 50, 7, chunk % 256))
    flight.session.receive()
    assert max(len(text.text) for text in flight.session.drain_texts()) <= 255 * 50


def stamped(flight: MadeFlight, offset_us: int) -> list[float]:
    """Hand the loop an image whose stamp is that far off; the velocities that answered it."""
    flight.turn(50, image=False)
    flight.show(flight.made.clock.stamp_us + offset_us)
    before = len(flight.made.transport.sent)
    flight.loop._turn()
    return forward_m_s(flight.sent()[before:])


@pytest.mark.parametrize("offset_s", [10, -100, 1_733_050_000, 2**31])
def test_images_are_answered_whatever_their_stamps(flight: MadeFlight, offset_s: int) -> None:
    for _ in range(100):
        flight.turn(2000)
        assert stamped(flight, offset_s * 1_000_000) == [2.0]
    assert flight.phase() is MissionPhase.FLYING
    assert flight.made.clock.stamp_us == 100 * 2_050_000
