"""Asking for some types gives what a whole read holds of them, whatever the log."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from pymavlink.dialects.v20 import all as mavlink

from flightstack.logs import Log, read
from flightstack.logs.dialect.message_types import message_id
from flightstack.logs.tlog.chain import find_chained
from flightstack.logs.tlog.clock import RunningClock, is_even
from flightstack.logs.tlog.source import MemorySource
from tests.unit.flightstack.logs.made_logs import (
    START_US,
    flight_messages,
    packet,
    random_packets,
    record,
    tlog,
)

FLIGHT = tlog(flight_messages(2000))
TYPES = ["ATTITUDE", "HEARTBEAT"]
IDS = [message_id(name) for name in TYPES]
WINDOW = 4096


def of_all_kinds() -> bytes:
    """Return a log of versions 1 and 2, signed packets, and messages that no definition knows."""
    packets = random_packets(300, 4) + random_packets(100, 5, version=1)
    packets += random_packets(100, 6, signed=True)
    packets += [packet(54321, bytes(range(n % 40 + 1)), extra=77) for n in range(100)]
    attitude = mavlink.MAVLink_attitude_message(7, 1, 2, 3, 4, 5, 6)
    packets += [attitude.pack(mavlink.MAVLink(None)) for _ in range(200)]
    order = np.random.default_rng(7).permutation(len(packets)).tolist()
    # the last bytes of a time look like the start of a version 1 packet, again and again
    times = (START_US // 65536 * 65536 + 0xFE20 + 65536 * place for place in range(len(packets)))
    return b"".join(record(time_us, packets[i]) for time_us, i in zip(times, order, strict=True))


def damaged(data: bytes) -> Iterator[bytes]:
    """Yield the log cut, with holes, flipped bytes, blocks twice, and times that jump."""
    rng = np.random.default_rng(8)
    for place in rng.integers(0, len(data), size=10).tolist():
        yield data[:place]
        yield data[:place] + data[place + 300 :]
        yield data[:place] + rng.bytes(50) + data[place:]
        yield data[: place + 400] + data[place:]
    for flips in (1, 1, 1, 1, 5, 50):
        hit = bytearray(data)
        for place in rng.integers(0, len(data), size=flips).tolist():
            hit[place] ^= 1 << int(rng.integers(0, 8))
        yield bytes(hit)


def assert_same(part: Log, whole: Log) -> None:
    expected = whole.select(types=TYPES)
    assert part.counts == expected.counts
    assert part.packets.offset.tolist() == expected.packets.offset.tolist()
    assert part.time_us.tolist() == expected.time_us.tolist()
    for name in TYPES:
        assert np.array_equal(part[name].data, expected[name].data)
        assert part[name].sequence.tolist() == expected[name].sequence.tolist()
    assert part.damage == whole.damage


@pytest.mark.parametrize("data", [FLIGHT, of_all_kinds()], ids=["flight", "all kinds"])
@pytest.mark.parametrize("window", [WINDOW, 1 << 20])
def test_whole_logs_are_read_along_their_chain(data: bytes, window: int, tmp_path: Path) -> None:
    packets = find_chained(MemorySource(np.frombuffer(data, dtype=np.uint8)), IDS, window)
    assert packets is not None
    assert set(packets.msgid.tolist()) == set(IDS)
    path = tmp_path / "log.tlog"
    path.write_bytes(data)
    assert_same(read(path, types=TYPES, window_bytes=window), read(path))


@pytest.mark.parametrize("data", [FLIGHT, of_all_kinds()], ids=["flight", "all kinds"])
def test_damaged_logs_give_the_same(data: bytes, tmp_path: Path) -> None:
    path = tmp_path / "log.tlog"
    for hit in damaged(data):
        path.write_bytes(hit)
        whole = read(path, window_bytes=WINDOW)
        assert_same(read(path, types=TYPES, window_bytes=WINDOW), whole)


def test_an_asked_for_packet_with_a_wrong_checksum_is_not_believed(tmp_path: Path) -> None:
    hit = bytearray(FLIGHT)
    hit[30] ^= 1  # in the payload of the first record, an ATTITUDE
    assert find_chained(MemorySource(np.frombuffer(hit, dtype=np.uint8)), IDS) is None
    path = tmp_path / "log.tlog"
    path.write_bytes(hit)
    assert len(read(path, types=["ATTITUDE"])) == len(read(path)["ATTITUDE"]) == 799


def test_a_jumping_clock_is_mended_from_all_messages(tmp_path: Path) -> None:
    message = flight_messages(1)[0].pack(mavlink.MAVLink(None))
    other = flight_messages(5)[4].pack(mavlink.MAVLink(None))
    times = np.arange(100) * 20_000 + START_US
    times[50] += 5_000_000
    stamped = zip(times.tolist(), [message, other] * 50, strict=True)
    data = b"".join(record(time_us, raw) for time_us, raw in stamped)
    assert find_chained(MemorySource(np.frombuffer(data, dtype=np.uint8)), IDS) is None
    path = tmp_path / "log.tlog"
    path.write_bytes(data)
    assert_same(read(path, types=TYPES), read(path))


def test_times_that_run_on_need_no_mending_whichever_are_left_out() -> None:
    rng = np.random.default_rng(9)
    steps = rng.integers(0, 1_500_000, size=400)
    times = np.cumsum(steps) - rng.integers(0, 400_000, size=400)
    kept = 0
    for start in range(0, 400, 20):
        some = times[start : start + 20]
        if not RunningClock().runs_on(some):
            continue
        pieces = RunningClock()
        assert all(pieces.runs_on(piece) for piece in np.split(some, (1, 7, 12)))
        for _ in range(20):
            part = some[rng.random(20) < 0.6]
            assert is_even(part)
            kept += 1
    assert kept > 100
