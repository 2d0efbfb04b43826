"""Read a log: from a file, from memory, or window by window."""

import re
from collections.abc import Iterable, Iterator
from fnmatch import fnmatchcase
from os import PathLike

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.columns.log import Log
from flightstack.logs.columns.time_axis import axis_of
from flightstack.logs.dialect.message_types import ids_by_name, message_id
from flightstack.logs.errors import LogFileError
from flightstack.logs.onboard.kinds import read_onboard
from flightstack.logs.tlog.chain import find_chained
from flightstack.logs.tlog.line_ends import restored_line_ends
from flightstack.logs.tlog.packets import IS_UNKNOWN, Packets, join
from flightstack.logs.tlog.scanner import scan
from flightstack.logs.tlog.source import (
    WINDOW_BYTES,
    ByteSource,
    MemorySource,
    held,
    mapped,
    open_source,
)
from flightstack.logs.tlog.unknown import implausible


def from_packets(source: ByteSource, packets: Packets) -> Log:
    """Return a log of packets that were found in `source`."""
    if (packets.flags & IS_UNKNOWN).any():
        packets = packets.take(~implausible(packets))
    return Log(source, packets, axis_of(source, packets))


def _known_ids(patterns: Iterable[str]) -> list[int] | None:
    """Return the ids that the patterns match; None if one might match an unknown message too."""
    found: set[int] = set()
    for pattern in patterns:
        start = re.split(r"[*?[]", pattern, maxsplit=1)[0]
        if "UNKNOWN_".startswith(start) or start.startswith("UNKNOWN_"):
            return None
        ids = [msgid for name, msgid in ids_by_name().items() if fnmatchcase(name, pattern)]
        found.update(ids or [message_id(pattern)])
    return sorted(found)


def _restored(log: Log, window_bytes: int = WINDOW_BYTES) -> Log:
    """Return the log of the bytes as they were before line endings in them were converted."""
    restored = restored_line_ends(log.source, log.packets)
    if restored is None:
        return log
    again = from_packets(restored, join(list(scan(restored, window_bytes))))
    return again if len(again) > len(log) else log


def _read_whole(source: ByteSource, window_bytes: int = WINDOW_BYTES) -> Log:
    """Return the log with all of its packets; LogFileError where there are none."""
    source = held(source)
    log = _restored(from_packets(source, join(list(scan(source, window_bytes)))), window_bytes)
    if not len(log):
        raise LogFileError(
            f"{source.name} holds no MAVLink packet: it is no tlog, or damaged throughout"
        )
    return log


def _read_types(source: ByteSource, patterns: Iterable[str], window_bytes: int) -> Log | None:
    """Return the log with packets of these types, None where it has to be read whole for them."""
    msgids = _known_ids(patterns)
    packets = None if msgids is None else find_chained(mapped(source), msgids, window_bytes)
    if packets is None:
        return None
    return Log(source, packets, packets.time_us, lambda: _read_whole(source, window_bytes))


def _read_tlog(source: ByteSource, patterns: list[str] | None, window_bytes: int) -> Log:
    log = None if patterns is None else _read_types(source, patterns, window_bytes)
    return _read_whole(source, window_bytes) if log is None else log


def _read_onboard(path: str | PathLike[str]) -> Log | None:
    """Return a vehicle's own log, PX4's .ulg or ArduPilot's .bin; None where the file is none."""
    records = read_onboard(path)
    if records is None:
        return None
    from flightstack.logs.columns.onboard_log import open_onboard  # noqa: PLC0415  # few are such

    return open_onboard(records)


def read(
    path: str | PathLike[str],
    *,
    types: Iterable[str] | None = None,
    system: int | None = None,
    component: int | None = None,
    start_us: int | None = None,
    end_us: int | None = None,
    window_bytes: int = WINDOW_BYTES,
) -> Log:
    """Read a log: a tlog, or the vehicle's own, PX4's .ulg or ArduPilot's .bin.

    Of a tlog every packet is found, every checksum is checked, and nothing is decoded yet.

    Where only some types are asked for, and the log is whole, checksums of others are not computed.
    The file is read in windows, so that memory is bounded by the index (26 bytes a packet) and by
    what is asked for. Raises LogFileError, one line that says what to do, for what is no log.
    """
    patterns = None if types is None else list(types)
    log = _read_onboard(path) or _read_tlog(open_source(path), patterns, window_bytes)
    return log.select(
        types=patterns, system=system, component=component, start_us=start_us, end_us=end_us
    )


def read_bytes(data: bytes | NDArray[np.uint8], name: str = "memory") -> Log:
    """Read a log from memory; one that holds no packet is an empty log."""
    source = MemorySource(np.frombuffer(data, dtype=np.uint8), name)
    return _restored(from_packets(source, join(list(scan(source)))))


def read_windows(
    path: str | PathLike[str],
    *,
    types: Iterable[str] | None = None,
    window_bytes: int = WINDOW_BYTES,
) -> Iterator[Log]:
    """Yield the log in pieces, one a window: memory stays bounded whatever the log's size."""
    source = open_source(path)
    patterns = None if types is None else list(types)
    for packets in scan(source, window_bytes):
        if len(packets):
            piece = from_packets(source, packets)
            yield piece if patterns is None else piece.select(types=patterns)
