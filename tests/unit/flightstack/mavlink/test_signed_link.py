"""Under a key the link heeds what is signed with it, and nothing else changes anything."""

from pathlib import Path
from typing import Any

import pytest
from pymavlink.dialects.v20 import common

from flightstack.mavlink.packets import split_packets
from flightstack.mavlink.signing import LATEST_TICKS, MINUTE_TICKS, Signing, Verdict
from tests.unit.flightstack.mavlink.made_link import VEHICLE, MadeLink, heartbeat
from tests.unit.flightstack.mavlink.test_signing import (
    KEY,
    NOW_TICKS,
    OTHER_KEY,
    Wall,
    pymavlink_end,
)

LANDED = common.MAVLink_extended_sys_state_message(0, 2)


@pytest.fixture
def made(tmp_path: Path) -> MadeLink:
    return MadeLink(tmp_path, Signing(KEY, wall_s=Wall()))


def kinds(messages: list[Any]) -> list[str]:
    return [message.get_type() for message in messages]


def test_only_a_signed_heartbeat_is_the_vehicle(made: MadeLink) -> None:
    made.say(heartbeat(), system=1)
    made.hear(bytes(heartbeat().pack(pymavlink_end(OTHER_KEY))))
    assert made.link.drain() == []
    assert made.link.vehicle is None
    made.hear(bytes(heartbeat().pack(pymavlink_end())))
    assert kinds(made.link.drain()) == ["HEARTBEAT"]
    assert made.link.vehicle is not None
    assert made.link.vehicle.signs


def test_signs_all_that_it_sends(made: MadeLink) -> None:
    vehicle = pymavlink_end()
    made.hear(bytes(heartbeat().pack(vehicle)))
    made.link.drain()
    for _ in range(3):
        made.link.send(heartbeat(autopilot=8))
    for packet, _ in made.transport.sent:
        assert vehicle.decode(bytearray(packet)).get_srcComponent() == 191
    assert vehicle.signing.goodsig_count == 3


def test_what_is_forged_replayed_or_unsigned_changes_nothing(made: MadeLink) -> None:
    vehicle = pymavlink_end()
    made.hear(bytes(heartbeat().pack(vehicle)))
    genuine = made.hear(bytes(LANDED.pack(vehicle)))
    assert len(made.link.drain()) == 2
    hostile = [
        genuine,
        bytes(LANDED.pack(pymavlink_end(OTHER_KEY))),
        bytes(LANDED.pack(pymavlink_end(OTHER_KEY, ticks=LATEST_TICKS))),
        bytes(LANDED.pack(pymavlink_end(ticks=NOW_TICKS - 1))),
        bytes(LANDED.pack(common.MAVLink(None, 1, 1))),
        bytes(heartbeat(mode=0x00030000).pack(common.MAVLink(None, 1, 1))),
    ]
    for packet in hostile:
        made.hear(packet)
        assert made.link.drain() == []
        made.hear(bytes(LANDED.pack(vehicle)))
        assert kinds(made.link.drain()) == ["EXTENDED_SYS_STATE"]
    assert made.link.refused == {Verdict.FORGED: 2, Verdict.REPLAYED: 2, Verdict.UNSIGNED: 1}


def test_logs_what_is_genuine_or_open_but_nothing_that_is_refused(made: MadeLink) -> None:
    beat = made.hear(bytes(heartbeat().pack(pymavlink_end())))
    open_beat = made.say(heartbeat(autopilot=8), system=255, component=190)
    made.say(LANDED, system=1)
    made.link.drain()
    made.link.close()
    content = made.tlog.path.read_bytes()
    logged = []
    while content:
        packet = split_packets(content[8:])[0][0]
        logged.append(packet)
        content = content[8 + len(packet) :]
    assert logged == [beat, open_beat]


def test_without_a_key_signatures_are_carried_along(tmp_path: Path) -> None:
    made = MadeLink(tmp_path)
    made.hear(bytes(heartbeat().pack(pymavlink_end())))
    assert kinds(made.link.drain()) == ["HEARTBEAT"]
    assert made.link.vehicle is not None
    assert made.link.vehicle.signs
    made.link.send(heartbeat())
    assert made.transport.sent[0][0][2] == 0


def test_an_authentic_but_old_heartbeat_is_answered_not_believed(made: MadeLink) -> None:
    made.hear(bytes(heartbeat().pack(pymavlink_end(ticks=NOW_TICKS - 10 * MINUTE_TICKS))))
    assert made.link.drain() == []
    assert made.link.vehicle is None
    made.link.send(heartbeat(autopilot=8))
    assert made.transport.sent[0][1] == VEHICLE
    made.hear(bytes(heartbeat().pack(pymavlink_end())), ("10.0.0.2", 14580))
    made.link.drain()
    made.link.send(heartbeat(autopilot=8))
    assert made.transport.sent[1][1] == ("10.0.0.2", 14580)


def test_a_forged_heartbeat_is_not_even_answered(made: MadeLink) -> None:
    made.hear(bytes(heartbeat().pack(pymavlink_end(OTHER_KEY))))
    made.link.drain()
    made.link.send(heartbeat(autopilot=8))
    assert made.transport.sent[0][1] is None
