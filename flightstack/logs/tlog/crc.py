"""Check the checksums of many MAVLink packets at once (CRC-16/MCRF4XX, as MAVLink uses it).

Two bytes a step: the state after a 16-bit word depends on state XOR word alone, so one table of
65,536 entries replaces two of the usual byte steps. Packets of like length are gathered as rows,
ends aligned and zeros before their first byte: from state zero, leading zeros change nothing. What
the true initial state would have added depends on the length alone, and is added at the end.
"""

from functools import cache

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.tlog.byte_view import at_every_byte
from flightstack.mavlink_numbers import CRC_START

POLYNOMIAL = 0x8408  # x^16 + x^12 + x^5 + 1, reflected
ROW_STEP = 8  # rows are multiples of this wide, so that few widths occur
MAX_BYTES = 512  # bytes under one checksum; MAVLink has at most 264


@cache
def byte_table() -> NDArray[np.uint16]:
    """Return the 256 states that follow from one byte and state zero."""
    table = np.arange(256, dtype=np.uint16)
    for _ in range(8):
        table = np.where(table & 1, (table >> 1) ^ POLYNOMIAL, table >> 1).astype(np.uint16)
    return table


@cache
def word_table() -> NDArray[np.uint16]:
    """Return the 65,536 states that follow from one little-endian word and state zero."""
    states = np.arange(1 << 16, dtype=np.uint16)
    for _ in range(2):
        states = (states >> 8) ^ byte_table()[states & 0xFF]
    return states


@cache
def initial_part() -> NDArray[np.uint16]:
    """Return the state after n zero bytes from the initial state, for n up to MAX_BYTES."""
    table = byte_table().tolist()
    states = [CRC_START]
    for _ in range(MAX_BYTES):
        states.append((states[-1] >> 8) ^ table[states[-1] & 0xFF])
    return np.array(states, dtype=np.uint16)


def step(crc: NDArray[np.uint16], byte: NDArray[np.uint16]) -> NDArray[np.uint16]:
    """Return the states after one more byte each."""
    result: NDArray[np.uint16] = (crc >> 8) ^ byte_table()[(crc ^ byte) & 0xFF]
    return result


def _row_checksums(rows: NDArray[np.uint8], lengths: NDArray[np.int64]) -> NDArray[np.uint16]:
    """Return the checksums of rows that end with `lengths` bytes of packet each."""
    width = rows.shape[1]
    low, high = width - int(lengths.max()), width - int(lengths.min())  # foreign bytes
    rows[:, :low] = 0
    if low < high:
        foreign = np.arange(low, high) < (width - lengths)[:, None]
        rows[:, low:high][foreign] = 0
    words = np.ascontiguousarray(rows.view("<u2").T)  # (width / 2, n): each step reads one row
    table = word_table()
    crc = np.zeros(len(rows), dtype=np.uint16)
    for word in words:
        np.bitwise_xor(crc, word, out=crc)
        table.take(crc, out=crc, mode="wrap")
    result: NDArray[np.uint16] = crc ^ initial_part()[lengths]
    return result


def checksums(
    data: NDArray[np.uint8], starts: NDArray[np.int64], lengths: NDArray[np.int64]
) -> NDArray[np.uint16]:
    """Return the checksum of data[start : start + length] for each pair, CRC_EXTRA not yet in."""
    if len(starts) and int(starts.min()) < ROW_STEP:
        data = np.concatenate((np.zeros(ROW_STEP, dtype=np.uint8), data))
        starts = starts + ROW_STEP
    result = np.empty(len(starts), dtype=np.uint16)
    step_counts = -(-lengths // ROW_STEP)
    for steps in np.flatnonzero(np.bincount(step_counts)).tolist():
        members = np.flatnonzero(step_counts == steps)
        width = steps * ROW_STEP
        first = starts[members] + lengths[members] - width
        rows = at_every_byte(data, f"V{width}")[first].view(np.uint8).reshape(len(members), width)
        result[members] = _row_checksums(rows, lengths[members])
    return result
