"""Signatures, with pymavlink as the other end."""

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sitl.mavlink.wire.dialect import mavlink
from sitl.mavlink.wire.packets import Packed, Received, pack, split, wrap
from sitl.mavlink.wire.refusals import Refusal
from sitl.mavlink.wire.signing import (
    MAX_STREAMS,
    NO_KEY,
    TOLERANCE,
    UNITS_PER_S,
    Signing,
    make_clock,
    wall_stamp,
)

KEY, OTHER_KEY = bytes(range(1, 33)), bytes(range(2, 34))
NOW = 36_000_000_000_000  # 10 us since 2015: in 2026
COMMAND = mavlink.MAVLink_command_long_message(1, 1, 400, 0, 1, *[0.0] * 6)
HEARTBEAT = mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3)


class Clock:
    def __init__(self) -> None:
        self.now = NOW

    def __call__(self) -> int:
        return self.now


class Client:
    """Somebody who signs with pymavlink."""

    def __init__(
        self, key: bytes = KEY, stamp: int = NOW, system: int = 255, link: int = 7
    ) -> None:
        self.codec = mavlink.MAVLink(None, srcSystem=system, srcComponent=190)
        self.codec.signing.secret_key = key
        self.codec.signing.sign_outgoing = True
        self.codec.signing.timestamp = stamp
        self.codec.signing.link_id = link

    def pack(self, message: Any = COMMAND) -> Received:
        (received,) = split(message.pack(self.codec))
        return received


def make_signing(key: bytes | None = KEY) -> tuple[Signing, Clock]:
    """Begin an hour ago."""
    clock = Clock()
    clock.now = NOW - 60 * TOLERANCE
    signing = Signing(key, clock=clock)
    clock.now = NOW
    return signing, clock


def unsigned(message: Any = COMMAND) -> Received:
    (received,) = split(wrap(pack(message), sequence=0, system=255, component=190))
    return received


def tampered(received: Received, place: int) -> Received:
    raw = bytearray(received.raw)
    raw[place] ^= 1
    return received._replace(raw=bytes(raw))


def sign(signing: Signing, packed: Packed, link: int = 2, sequence: int = 0) -> bytes:
    raw = wrap(packed, sequence=sequence, system=1, component=1, is_signed=True)
    return raw + signing.signature(raw, link)


def test_without_a_key_everything_is_heeded() -> None:
    signing, _ = make_signing(None)
    assert signing.judge(unsigned()) is None
    assert signing.judge(Client(OTHER_KEY).pack()) is None
    assert not signing.is_on


def test_what_pymavlink_signs_is_accepted() -> None:
    signing, _ = make_signing()
    client = Client()
    assert [signing.judge(client.pack()) for _ in range(5)] == [None] * 5


def test_what_we_sign_is_accepted_by_pymavlink() -> None:
    signing, clock = make_signing()
    reader = mavlink.MAVLink(None)
    reader.signing.secret_key = KEY
    reader.signing.timestamp = NOW
    for sequence in range(5):  # the clock stands: stamps must grow all the same
        raw = sign(signing, pack(COMMAND), sequence=sequence)
        message = reader.decode(bytearray(raw))
        assert message.get_signed()
        assert message.get_link_id() == 2
    clock.now += UNITS_PER_S
    reader.decode(bytearray(sign(signing, pack(COMMAND))))
    assert reader.signing.stream_timestamps == {(2, 1, 1): NOW + UNITS_PER_S}
    other = mavlink.MAVLink(None)
    other.signing.secret_key = OTHER_KEY
    with pytest.raises(mavlink.MAVError):
        other.decode(bytearray(sign(signing, pack(COMMAND))))


@given(st.binary(min_size=32, max_size=32).filter(any), st.integers(0, 255), st.binary(max_size=8))
def test_any_key_and_any_payload_agree_with_pymavlink(key: bytes, link: int, tail: bytes) -> None:
    signing, _ = make_signing(key)
    reader = mavlink.MAVLink(None)
    reader.signing.secret_key = key
    message = mavlink.MAVLink_statustext_message(6, b"text" + tail)
    assert reader.decode(bytearray(sign(signing, pack(message), link))).get_link_id() == link
    assert signing.judge(Client(key, link=link).pack(message)) is None


@pytest.mark.parametrize(
    ("name", "refusal"),
    [
        ("forged", Refusal.BAD_SIGNATURE),
        ("forged far ahead", Refusal.BAD_SIGNATURE),
        ("replayed", Refusal.REPLAYED),
        ("unsigned", Refusal.UNSIGNED),
        ("future", Refusal.FUTURE),
    ],
)
def test_a_bad_packet_changes_nothing_and_a_valid_one_after_it_is_accepted(
    name: str, refusal: Refusal
) -> None:
    signing, _ = make_signing()
    client = Client()
    first = client.pack()
    assert signing.judge(first) is None
    bad = {
        "forged": Client(OTHER_KEY, NOW + 1).pack(),
        "forged far ahead": Client(OTHER_KEY, 2**47).pack(),
        "replayed": first,
        "unsigned": unsigned(),
        "future": Client(KEY, NOW + TOLERANCE + 1).pack(),
    }[name]
    for _ in range(3):
        assert signing.judge(bad) is refusal
        assert signing.judge(client.pack()) is None


def test_pymavlink_itself_is_poisoned_by_what_we_refuse() -> None:
    reader = mavlink.MAVLink(None)
    reader.signing.secret_key = KEY
    with pytest.raises(mavlink.MAVError):
        reader.decode(bytearray(Client(OTHER_KEY, 2**47).pack().raw))
    with pytest.raises(mavlink.MAVError):  # a valid one: why we have a verifier of our own
        reader.decode(bytearray(Client().pack().raw))


@given(st.data())
def test_no_changed_bit_is_accepted(data: st.DataObject) -> None:
    signing, _ = make_signing()
    client = Client()
    good = client.pack()
    place = data.draw(st.integers(3, len(good.raw) - 1))  # before it stand magic, length and flags
    assert signing.judge(tampered(good, place)) is Refusal.BAD_SIGNATURE
    assert signing.judge(good) is None


@given(st.lists(st.integers(0, 40), max_size=60))
def test_of_each_stream_only_growing_stamps_are_accepted(steps: list[int]) -> None:
    signing, _ = make_signing()
    newest = NOW - 100
    for step in steps:
        stamp = NOW - 20 + step
        accepted = signing.judge(Client(stamp=stamp).pack()) is None
        assert accepted == (stamp > newest)
        newest = max(newest, stamp)


def test_streams_do_not_mix() -> None:
    signing, _ = make_signing()
    for system, link in ((255, 1), (255, 2), (254, 1)):
        assert signing.judge(Client(stamp=NOW - 5, system=system, link=link).pack()) is None


@pytest.mark.parametrize(
    ("stamp", "refusal"),
    [
        (NOW - TOLERANCE, None),
        (NOW - TOLERANCE - 1, Refusal.STALE),
        (NOW + TOLERANCE, None),
        (NOW + TOLERANCE + 1, Refusal.FUTURE),
    ],
)
def test_a_new_stream_may_be_a_minute_off(stamp: int, refusal: Refusal | None) -> None:
    signing, _ = make_signing()
    assert signing.judge(Client(stamp=stamp).pack()) is refusal


def test_what_was_signed_before_the_start_does_not_come_again() -> None:
    clock = Clock()
    signing = Signing(KEY, clock=clock)
    assert signing.judge(Client(stamp=NOW - 1).pack()) is Refusal.STALE
    assert signing.judge(Client(stamp=NOW).pack()) is None


def test_the_table_is_bounded_and_forgets_only_what_cannot_be_replayed() -> None:
    signing, clock = make_signing()
    old = [Client(stamp=NOW, link=link).pack() for link in range(MAX_STREAMS)]
    assert [signing.judge(received) for received in old] == [None] * MAX_STREAMS
    late = Client(stamp=NOW, link=255)
    assert signing.judge(late.pack()) is Refusal.CROWDED
    clock.now += TOLERANCE + 1
    assert signing.judge(Client(stamp=clock.now, link=255).pack()) is None
    assert {signing.judge(received) for received in old} == {Refusal.STALE}
    assert len(signing._streams) <= MAX_STREAMS


def test_only_px4s_exceptions_may_be_unsigned_but_not_badly_signed() -> None:
    signing, _ = make_signing()
    assert signing.judge(unsigned(HEARTBEAT)) is None
    assert signing.judge(unsigned(COMMAND)) is Refusal.UNSIGNED
    assert signing.judge(Client(OTHER_KEY).pack(HEARTBEAT)) is Refusal.BAD_SIGNATURE
    (old,) = split(COMMAND.pack(mavlink.MAVLink(None), force_mavlink1=True))
    assert signing.judge(old) is Refusal.UNSIGNED


def test_a_new_key_takes_over_and_is_kept() -> None:
    kept: list[bytes | None] = []
    signing = Signing(None, clock=Clock(), keep=kept.append)
    signing.set_up(KEY, NOW)
    old = Client().pack()
    assert signing.judge(old) is None
    signing.set_up(OTHER_KEY, NOW)
    assert signing.judge(Client(stamp=NOW + 9).pack()) is Refusal.BAD_SIGNATURE
    assert signing.judge(Client(OTHER_KEY, NOW + 9).pack()) is None
    signing.set_up(KEY, NOW)  # back again: what was accepted once stays used
    assert signing.judge(old) is Refusal.REPLAYED
    signing.set_up(NO_KEY, 0)
    assert not signing.is_on
    assert kept == [KEY, OTHER_KEY, KEY, None]
    with pytest.raises(ValueError, match="no key"):
        signing.signature(b"", 0)


def test_a_ground_station_whose_clock_is_ahead_sets_the_time_with_the_key() -> None:
    signing, _ = make_signing(None)
    ahead = NOW + 10 * TOLERANCE
    signing.set_up(KEY, ahead)
    assert signing.judge(Client(stamp=ahead + 1).pack()) is None
    signing.set_up(KEY, 2**64 - 1)  # absurd: our stamps still fit their 48 bits
    assert len(sign(signing, pack(COMMAND))) > 13


def test_stamps_follow_the_wall_clock() -> None:
    assert wall_stamp(1_420_070_400 * 10**9) == 0
    assert wall_stamp(1_420_070_401 * 10**9) == UNITS_PER_S
    assert wall_stamp(0) == 0
    clock = make_clock()
    assert NOW - 10 * TOLERANCE * 60 * 24 * 365 < clock() <= clock()
