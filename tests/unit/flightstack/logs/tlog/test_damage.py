"""Whatever happens to a file, every packet whose checksum holds comes back, and no other."""

from collections import Counter
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from flightstack.logs import Log, read, read_bytes
from flightstack.logs.columns.reading import from_packets
from flightstack.logs.tlog.packets import join
from flightstack.logs.tlog.scanner import scan
from flightstack.logs.tlog.source import MemorySource
from tests.unit.flightstack.logs.made_logs import (
    START_US,
    flight_messages,
    packet,
    pymavlink_messages,
    random_packets,
    record,
    tlog,
)

RECORDS = 3000
HOLE = 4096


def clean_packets() -> list[bytes]:
    packets = random_packets(RECORDS // 2, 1)
    packets += random_packets(RECORDS // 4, 2, signed=True, system=2)
    return packets + random_packets(RECORDS // 4, 3, version=1, system=3)


PACKETS = clean_packets()
RECORDED = [record(START_US + i * 5000, raw) for i, raw in enumerate(PACKETS)]
CLEAN = b"".join(RECORDED)
STARTS = np.cumsum([0, *map(len, RECORDED)])[:-1]


def raw_packets(log: Log) -> list[bytes]:
    data = log.source.read(0, log.source.size)
    pairs = zip(log.packets.offset.tolist(), log.packets.end.tolist(), strict=True)
    return [data[start:end].tobytes() for start, end in pairs]


def unsigned(packets: Iterable[bytes]) -> Counter[bytes]:
    """Count packets without their signatures, which the checksum does not cover."""
    return Counter(f[: 12 + f[1]] if f[0] == 0xFD else f for f in packets)


KNOWN = unsigned(PACKETS).keys()


def intact(damaged: NDArray[np.bool_]) -> Counter[bytes]:
    """Return the packets none of whose bytes is damaged."""
    ends = STARTS + [len(r) for r in RECORDED]
    return Counter(
        raw
        for raw, start, end in zip(PACKETS, STARTS.tolist(), ends.tolist(), strict=True)
        if not damaged[start + 8 : end].any()
    )


def assert_recovers(data: bytes, expected: Counter[bytes], path: Path) -> Log:
    """Check ours against what is intact, and that pymavlink finds nothing that we do not."""
    log = read_bytes(data)
    ours = unsigned(raw_packets(log))
    assert not ours.keys() - KNOWN, "a packet that never was"
    assert not unsigned(expected.elements()) - ours, "an intact packet is missing"
    path.write_bytes(data)
    theirs = unsigned(bytes(m.get_msgbuf()) for m in pymavlink_messages(path))
    true_ones = Counter({raw: n for raw, n in theirs.items() if raw in KNOWN})
    assert not true_ones - ours, "pymavlink finds a packet that we do not"
    return log


def test_a_clean_log_has_no_damage(tmp_path: Path) -> None:
    log = assert_recovers(CLEAN, Counter(PACKETS), tmp_path / "log.tlog")
    assert log.damage.is_clean
    assert all(loss.lost == loss.reordered == 0 for loss in log.losses)


def test_flipped_bytes_cost_only_their_packets(tmp_path: Path) -> None:
    for seed in range(5):
        rng = np.random.default_rng(seed)
        data = np.frombuffer(CLEAN, dtype=np.uint8).copy()
        damaged = np.zeros(len(data), dtype=np.bool_)
        places = rng.choice(len(data), size=100, replace=False)
        data[places] ^= rng.integers(1, 256, size=100, dtype=np.uint8)
        damaged[places] = True
        log = assert_recovers(data.tobytes(), intact(damaged), tmp_path / "log.tlog")
        assert {region.kind for region in log.damage.regions} >= {"damaged frame"}
        assert sum(loss.lost for loss in log.losses) > 0


def test_holes_cost_only_what_they_cover(tmp_path: Path) -> None:
    for seed in range(5):
        rng = np.random.default_rng(seed)
        damaged = np.zeros(len(CLEAN), dtype=np.bool_)
        for start in rng.integers(0, len(CLEAN) - HOLE, size=3).tolist():
            damaged[start : start + HOLE] = True
        whole = np.frombuffer(CLEAN, dtype=np.uint8)
        zeroed = np.where(damaged, 0, whole).astype(np.uint8).tobytes()
        assert_recovers(zeroed, intact(damaged), tmp_path / "log.tlog")
        assert_recovers(whole[~damaged].tobytes(), intact(damaged), tmp_path / "log.tlog")


def test_garbage_between_packets_is_skipped_and_located(tmp_path: Path) -> None:
    rng = np.random.default_rng(5)
    parts: list[bytes] = []
    for index, piece in enumerate(RECORDED):
        if index % 100 == 50:
            parts.append(rng.bytes(int(rng.integers(1, 3000))))
        parts.append(piece)
    log = assert_recovers(b"".join(parts), Counter(PACKETS), tmp_path / "log.tlog")
    assert len(log.damage.regions) == RECORDS // 100
    assert log.damage.lost_bytes == sum(map(len, parts)) - len(CLEAN)


def test_duplicated_blocks_are_read_twice_and_counted(tmp_path: Path) -> None:
    block = slice(1000, 1200)
    parts = [*RECORDED[:2000], *RECORDED[block], *RECORDED[2000:]]
    expected = Counter(PACKETS) + Counter(PACKETS[block])
    log = assert_recovers(b"".join(parts), expected, tmp_path / "log.tlog")
    assert log.damage.duplicates == 200
    assert [jump.jump_us < 0 for jump in log.damage.jumps] == [True]


@pytest.mark.parametrize("version", [1, 2])
def test_cut_at_every_byte_of_a_record(version: int, tmp_path: Path) -> None:
    del tmp_path
    packets = random_packets(40, 9, version=version)
    recorded = [record(START_US + i * 5000, raw) for i, raw in enumerate(packets)]
    whole = b"".join(recorded)
    for cut in range(len(whole) - len(recorded[-1]) - len(recorded[-2]), len(whole)):
        log = read_bytes(whole[:cut])
        present = sum(cut >= end for end in np.cumsum([len(r) for r in recorded]).tolist())
        assert raw_packets(log) == packets[:present]
        assert log.damage.is_cut == (cut != sum(len(r) for r in recorded[:present]))
    for cut in range(len(recorded[0]) + 1):
        log = read_bytes(whole[cut:])
        assert raw_packets(log) == (packets if cut <= 8 else packets[1:])


def test_a_stream_without_times_is_read_too() -> None:
    log = read_bytes(b"".join(PACKETS))
    assert raw_packets(log) == PACKETS
    assert not log.damage.has_times
    assert not log.damage.regions


def test_a_stream_without_times_takes_them_from_its_messages() -> None:
    whole = read_bytes(tlog(flight_messages(500)))
    stream = read_bytes(b"".join(raw_packets(whole)))
    steps = np.diff(stream["ATTITUDE"].time_us)
    assert steps.tolist() == (np.diff(whole["ATTITUDE"].time_us)).tolist()


def test_damaged_times_are_mended() -> None:
    times = [START_US + i * 5000 for i in range(RECORDS)]
    for index, wrong in ((700, 0), (701, 2**63 + 5), (1500, START_US * 2), (2999, 7)):
        times[index] = wrong
    data = b"".join(record(t, raw) for t, raw in zip(times, PACKETS, strict=True))
    log = read_bytes(data)
    assert raw_packets(log) == PACKETS
    assert np.all(np.diff(log.time_us) >= 0)
    assert log.damage.mended_times == 4
    assert not log.damage.jumps


def test_a_jumping_clock_is_reported_not_mended() -> None:
    hour_us = 3_600_000_000
    times = [START_US + i * 5000 + (hour_us if i >= 1000 else 0) for i in range(RECORDS)]
    log = read_bytes(b"".join(record(t, raw) for t, raw in zip(times, PACKETS, strict=True)))
    assert log.time_us.tolist() == times
    assert [(jump.row, jump.jump_us) for jump in log.damage.jumps] == [(1000, hour_us + 5000)]


def test_windows_of_any_size_find_the_same_packets() -> None:
    rng = np.random.default_rng(3)
    data = np.frombuffer(CLEAN, dtype=np.uint8).copy()
    data[rng.choice(len(data), size=300, replace=False)] ^= 0x55
    source = MemorySource(data)
    whole = from_packets(source, join(list(scan(source))))
    for window_bytes in (600, 4096, 65_536):
        log = from_packets(source, join(list(scan(source, window_bytes))))
        assert log.packets.offset.tolist() == whole.packets.offset.tolist()
        assert log.packets.time_us.tolist() == whole.packets.time_us.tolist()


def test_garbage_alone_holds_no_packet() -> None:
    garbage = np.random.default_rng(11).bytes(8 << 20)
    assert len(read_bytes(garbage)) == 0


def test_sequence_gaps_give_the_loss_of_each_sender() -> None:
    recorded = tlog(flight_messages(1000))
    log = read_bytes(recorded)
    keep = [i for i in range(1000) if i % 10 != 3]
    starts, ends = log.packets.offset - 8, log.packets.end
    thinned = b"".join(recorded[starts[i] : ends[i]] for i in keep)
    (loss,) = read_bytes(thinned).losses
    assert (loss.system, loss.component, loss.received, loss.lost) == (1, 1, 900, 100)
    assert loss.fraction == pytest.approx(0.1)


def test_links_told_apart_by_their_bits_are_no_loss() -> None:
    parts = []
    for i in range(300):
        for link in range(2):
            raw = packet(30, bytes([1 + i % 200]) * 28, sequence=(i * (1 + link)) % 256)
            if link == 0 or i % 2 == 0:
                parts.append(record(((START_US + i * 8000) & ~3) | link, raw))
    (loss,) = read_bytes(b"".join(parts)).losses
    assert loss.lost < 460  # the second link misses what it misses, the first one nothing


def test_unknown_packets_that_disagree_are_not_believed() -> None:
    packets = [packet(54321, bytes([i, 2, 3]), sequence=i, extra=99) for i in range(1, 6)]
    packets[2] = packet(54321, bytes([3, 2, 3]), sequence=3, extra=98)
    log = read_bytes(b"".join(record(START_US, raw) for raw in packets))
    assert raw_packets(log) == [*packets[:2], *packets[3:]]


@pytest.mark.parametrize("seed", range(4))
def test_no_input_raises(seed: int) -> None:
    rng = np.random.default_rng(seed)
    for _ in range(300):
        start = int(rng.integers(0, len(CLEAN) - 2000))
        piece = np.frombuffer(CLEAN[start : start + int(rng.integers(0, 2000))], np.uint8).copy()
        for _ in range(int(rng.integers(0, 20))):
            if len(piece):
                piece[rng.integers(0, len(piece))] = rng.choice([0xFD, 0xFE, 0, 255, 1])
        log = read_bytes(piece)
        log.load(log.counts)
        assert log.damage.lost_bytes <= len(piece)
        assert len(log.losses) <= len(log)


def test_a_file_reads_like_memory(tmp_path: Path) -> None:
    path = tmp_path / "log.tlog"
    path.write_bytes(CLEAN)
    assert read(path).packets.offset.tolist() == read_bytes(CLEAN).packets.offset.tolist()
