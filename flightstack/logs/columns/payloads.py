"""Gather the payloads of chosen packets into one array a message, reading the log once."""

from collections.abc import Iterator, Mapping

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.tlog.byte_view import at_every_byte
from flightstack.logs.tlog.packets import Packets
from flightstack.logs.tlog.source import WINDOW_BYTES, ByteSource

Bytes = NDArray[np.uint8]


def _fill(rows: Bytes, window: Bytes, at: NDArray[np.int64], length: NDArray[np.int64]) -> None:
    """Copy payloads at `at` into rows; bytes that were trimmed on the wire become zero."""
    size = rows.shape[1]
    room = int(at.max()) + size - len(window)
    if room > 0:
        window = np.concatenate((window, np.zeros(room, dtype=np.uint8)))
    rows[:] = at_every_byte(window, f"V{size}")[at].view(np.uint8).reshape(len(at), size)
    if int(length.min()) < size:
        rows[np.arange(size) >= length[:, None]] = 0


def _windows_needed(
    wanted: Mapping[int, tuple[Packets, int]], size: int
) -> Iterator[tuple[int, int]]:
    """Yield the windows, as (start, stop), in which at least one wanted packet starts."""
    needed = np.zeros(size // WINDOW_BYTES + 1, dtype=np.bool_)
    lowest, highest = size, 0
    for packets, _ in wanted.values():
        needed[packets.offset // WINDOW_BYTES] = True
        lowest = min(lowest, int(packets.offset[0]))
        highest = max(highest, int(packets.offset[-1]))
    for number in np.flatnonzero(needed).tolist():
        start, stop = number * WINDOW_BYTES, (number + 1) * WINDOW_BYTES
        yield max(start, lowest), min(stop, highest + 1)


def gather(source: ByteSource, wanted: Mapping[int, tuple[Packets, int]]) -> dict[int, Bytes]:
    """Return the payloads (n, size) of each key's packets; packets in file order, size in bytes."""
    payloads = {
        key: np.empty((len(packets), size), dtype=np.uint8)
        for key, (packets, size) in wanted.items()
    }
    starts = {key: packets.offset + packets.header_length for key, (packets, _) in wanted.items()}
    for start, stop in _windows_needed(wanted, source.size):
        window = source.read(start, stop + 512)
        for key, (packets, _) in wanted.items():
            first, last = np.searchsorted(packets.offset, (start, stop))
            if first < last:
                length = packets.length[first:last].astype(np.int64)
                _fill(payloads[key][first:last], window, starts[key][first:last] - start, length)
    return payloads
