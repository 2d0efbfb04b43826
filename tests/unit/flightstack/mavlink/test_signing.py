"""Signatures, with pymavlink at the other end of the wire."""

import hashlib
import itertools
import time
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common

from flightstack.errors import UsageError
from flightstack.mavlink.packets import split_packets
from flightstack.mavlink.signing import (
    EPOCH_S,
    LATEST_TICKS,
    MAX_STREAMS,
    MINUTE_TICKS,
    TICKS_PER_S,
    Signing,
    Verdict,
    load_key,
)

KEY = hashlib.sha256(b"a passphrase").digest()
OTHER_KEY = hashlib.sha256(b"another").digest()
NOW_TICKS = 37_000_000_000_000  # September 2026
NOW_S = EPOCH_S + NOW_TICKS / TICKS_PER_S
BEAT = common.MAVLink_heartbeat_message(2, 12, 81, 0x10000, 3, 3)
ARM = common.MAVLink_command_long_message(1, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0)


class Wall:
    def __init__(self, now_s: float = NOW_S) -> None:
        self.now_s = now_s

    def __call__(self) -> float:
        return self.now_s


def signing(**options: Any) -> Signing:
    return Signing(KEY, **({"wall_s": Wall()} | options))


def pymavlink_end(
    key: bytes | None = KEY, *, ticks: int = NOW_TICKS, link_id: int = 0, component: int = 1
) -> Any:
    """Make what `mavutil.setup_signing` makes of a connection."""
    end = common.MAVLink(None, 1, component)
    end.signing.secret_key = key
    end.signing.sign_outgoing = key is not None
    end.signing.link_id = link_id
    end.signing.timestamp = ticks
    return end


def unsigned(message: Any, *, component: int = 191, **options: Any) -> bytes:
    return bytes(message.pack(common.MAVLink(None, 1, component), **options))


def stamp_of(packet: bytes) -> int:
    return int.from_bytes(packet[-12:-6], "little")


any_message = st.one_of(
    st.builds(
        common.MAVLink_attitude_message,
        st.integers(0, 2**32 - 1),
        *[st.floats(width=32, allow_nan=False)] * 6,
    ),
    st.builds(
        common.MAVLink_statustext_message,
        st.integers(0, 7),
        st.binary(max_size=50),
    ),
    st.just(BEAT),
    st.just(ARM),
)


@given(messages=st.lists(any_message, min_size=1, max_size=5), link_id=st.integers(0, 255))
def test_pymavlink_believes_what_we_sign(messages: list[Any], link_id: int) -> None:
    ours, theirs = signing(link_id=link_id), pymavlink_end()
    for message in messages:
        packet = ours.sign(unsigned(message))
        assert split_packets(packet) == ([packet], len(packet))
        heard = theirs.decode(bytearray(packet)).to_dict()
        assert heard == pymavlink_end(None).decode(bytearray(unsigned(message))).to_dict()
    assert theirs.signing.goodsig_count == len(messages)


@given(message=any_message, flipped=st.integers(0, 10_000))
def test_no_bit_can_be_changed(message: Any, flipped: int) -> None:
    packet = bytearray(signing().sign(unsigned(message)))
    bit = flipped % (8 * (len(packet) - 1)) + 8  # all but the packet's first byte
    packet[bit // 8] ^= 1 << bit % 8
    assert signing().verify(bytes(packet)) in (Verdict.FORGED, Verdict.UNSIGNED, Verdict.OPEN)


@given(messages=st.lists(any_message, min_size=1, max_size=5), link_id=st.integers(0, 255))
def test_we_believe_what_pymavlink_signs_and_nothing_twice(
    messages: list[Any], link_id: int
) -> None:
    ours, theirs = signing(), pymavlink_end(link_id=link_id)
    packets = [bytes(message.pack(theirs)) for message in messages]
    assert [ours.verify(packet) for packet in packets] == [Verdict.GENUINE] * len(packets)
    assert {ours.verify(packet) for packet in packets} == {Verdict.REPLAYED}


def test_another_key_is_a_forgery() -> None:
    assert signing().verify(bytes(ARM.pack(pymavlink_end(OTHER_KEY)))) is Verdict.FORGED


@pytest.mark.parametrize("options", [{}, {"force_mavlink1": True}])
def test_what_is_not_signed_is_refused_unless_px4_takes_it_too(options: dict[str, bool]) -> None:
    radio = common.MAVLink_radio_status_message(1, 2, 3, 4, 5, 6, 7)
    verdicts = [signing().verify(unsigned(message, **options)) for message in (ARM, BEAT, radio)]
    assert verdicts == [Verdict.UNSIGNED, Verdict.OPEN, Verdict.OPEN]


def test_a_forged_far_future_changes_nothing_while_it_silences_pymavlink() -> None:
    ours, theirs = signing(), pymavlink_end()
    theirs.robust_parsing = True
    sender = pymavlink_end(component=25)
    forger = pymavlink_end(OTHER_KEY, ticks=LATEST_TICKS, component=25)
    first, forged, later = (bytes(ARM.pack(end)) for end in (sender, forger, sender))
    assert [ours.verify(packet) for packet in (first, forged, later)] == [
        Verdict.GENUINE,
        Verdict.FORGED,
        Verdict.GENUINE,
    ]
    heard = [theirs.parse_buffer(packet)[0].get_type() for packet in (first, forged, later)]
    assert heard == ["COMMAND_LONG", "BAD_DATA", "BAD_DATA"]  # the flaw: the last one is genuine


@given(forged=st.lists(st.tuples(st.integers(0, 255), st.integers(0, 255)), max_size=60))
def test_forgeries_leave_no_trace(forged: list[tuple[int, int]]) -> None:
    ours = signing()
    for link_id, component in forged:
        end = pymavlink_end(OTHER_KEY, ticks=LATEST_TICKS, link_id=link_id, component=component)
        assert ours.verify(bytes(ARM.pack(end))) is Verdict.FORGED
    assert ours._streams == {}
    assert stamp_of(ours.sign(unsigned(ARM))) == NOW_TICKS
    assert ours.verify(bytes(ARM.pack(pymavlink_end()))) is Verdict.GENUINE


def test_streams_have_times_of_their_own() -> None:
    ours = signing()
    for end in (pymavlink_end(link_id=1), pymavlink_end(link_id=2), pymavlink_end(component=25)):
        assert ours.verify(bytes(ARM.pack(end))) is Verdict.GENUINE


def test_the_table_of_streams_is_bounded() -> None:
    ours = signing()
    ends = [pymavlink_end(component=component) for component in range(1, MAX_STREAMS + 6)]
    verdicts = [ours.verify(bytes(ARM.pack(end))) for end in ends]
    assert verdicts == [Verdict.GENUINE] * MAX_STREAMS + [Verdict.CROWDED] * 5
    assert ours.verify(bytes(ARM.pack(ends[0]))) is Verdict.GENUINE


@pytest.mark.parametrize(
    ("behind", "verdict"), [(MINUTE_TICKS, Verdict.GENUINE), (MINUTE_TICKS + 1, Verdict.STALE)]
)
def test_a_new_stream_may_be_a_minute_behind(behind: int, verdict: Verdict) -> None:
    end = pymavlink_end(ticks=NOW_TICKS - behind)
    assert signing().verify(bytes(ARM.pack(end))) is verdict


@given(moves_s=st.lists(st.floats(-1e4, 1e4), max_size=30))
def test_our_timestamps_grow_whatever_the_wall_clock_does(moves_s: list[float]) -> None:
    wall = Wall()
    ours = signing(wall_s=wall)
    stamps = []
    for move_s in moves_s:
        wall.now_s += move_s
        stamps.append(stamp_of(ours.sign(unsigned(BEAT))))
    assert all(before < after for before, after in itertools.pairwise(stamps))


def test_our_timestamps_count_10_us_since_2015_and_grow_across_restarts() -> None:
    wall, peer = Wall(), pymavlink_end(component=191)
    stamps = []
    for _ in range(3):  # runs of the program, each 0.1 s after the one before
        ours = signing(wall_s=wall)
        packets = [ours.sign(unsigned(ARM)) for _ in range(1000)]
        stamps += [stamp_of(packet) for packet in packets]
        for packet in packets:
            peer.decode(bytearray(packet))
        wall.now_s += 0.1
    assert stamps[0] == NOW_TICKS
    assert stamps[1000] == pytest.approx(NOW_TICKS + TICKS_PER_S // 10, abs=1)
    assert peer.signing.goodsig_count == 3000


def test_signs_with_the_time_of_day_by_default() -> None:
    before = (time.time() - EPOCH_S) * TICKS_PER_S
    first, second = (stamp_of(Signing(KEY).sign(unsigned(BEAT))) for _ in range(2))
    after = (time.time() - EPOCH_S) * TICKS_PER_S
    assert before - 1 <= first <= second <= after + 1


def test_without_a_clock_of_our_own_the_vehicles_counts() -> None:
    ours, vehicle = signing(wall_s=Wall(0.0)), pymavlink_end()
    assert ours.verify(bytes(BEAT.pack(vehicle))) is Verdict.GENUINE
    packet = ours.sign(unsigned(ARM))
    assert stamp_of(packet) > NOW_TICKS
    assert vehicle.decode(bytearray(packet)).command == 400


def test_the_end_of_time_is_no_error() -> None:
    ours = signing()
    assert ours.verify(bytes(ARM.pack(pymavlink_end(ticks=LATEST_TICKS)))) is Verdict.GENUINE
    assert stamp_of(ours.sign(unsigned(BEAT))) == LATEST_TICKS


@pytest.mark.parametrize("content", [KEY, KEY.hex().encode(), KEY.hex().upper().encode() + b"\r\n"])
def test_reads_a_key_in_bytes_or_hexadecimal_digits(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "key"
    path.write_bytes(content)
    assert load_key(path) == KEY


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (b"", "holds neither 32 bytes nor 64 hexadecimal digits"),
        (KEY[:31], "holds neither"),
        (KEY + b"\n", "holds neither"),
        (KEY.hex()[:-1].encode(), "holds neither"),
        (b"g" * 64, "holds neither"),
        (b"\xff" * 64, "holds neither"),
        (b"5" * 100_000, "holds neither"),
        (bytes(32), "all zeros"),
        (b"0" * 64, "all zeros"),
    ],
)
def test_refuses_what_is_no_key(content: bytes, reason: str, tmp_path: Path) -> None:
    path = tmp_path / "key"
    path.write_bytes(content)
    with pytest.raises(UsageError, match=reason) as refusal:
        load_key(path)
    assert str(path) in str(refusal.value)
    assert "\n" not in str(refusal.value)
    assert KEY.hex()[:10] not in str(refusal.value)


def test_refuses_a_key_file_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="No such file"):
        load_key(tmp_path / "nowhere")
    with pytest.raises(UsageError, match="Is a directory"):
        load_key(tmp_path)


def test_refuses_a_key_of_another_length() -> None:
    with pytest.raises(ValueError, match="expected 32 bytes, got 16"):
        Signing(KEY[:16])
