"""Read the clock that an autopilot starts at each boot, from the times in its messages."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.columns.payloads import gather
from flightstack.logs.columns.table import Table
from flightstack.logs.dialect.message_types import MessageType, ids_by_name, message_type
from flightstack.logs.tlog.clock import LATEST_US
from flightstack.logs.tlog.packets import Packets, tally
from flightstack.logs.tlog.source import ByteSource

CLOCK_FIELDS = ("time_boot_ms", "time_usec", "time_us", "timestamp")
CLOCKED = ("ATTITUDE", "LOCAL_POSITION_NED", "GLOBAL_POSITION_INT", "SYSTEM_TIME")  # since boot
MAX_CLOCKED = 3  # messages that are looked at, where none of those is there
MICROSECONDS = {"ms": 1000, "us": 1}
RESTART_US = 1_000_000  # a step back of more than this: the autopilot started again
WRAP_US = 1000 << 32  # where time_boot_ms begins anew after 49 days
LEAP_US = 3_600_000_000  # a step ahead beyond this is no clock
MIN_ROWS = 10  # messages, to believe a clock against the stamps
MAX_STRANGE_SHARE = 0.02  # of the steps, back or far ahead, of what is still a clock

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class BootClock:
    """One sender's clock at some packets; it never runs backwards."""

    rows: Rows  # of the packets in the log
    elapsed_us: Floats  # since the first of its messages; across a restart it stands still
    first_us: float  # what the clock said there
    restarts: Rows  # places in `rows` at which it had started again

    def at(self, rows: Rows) -> Floats:
        """Return the elapsed time at any packets, by their place between the clock's own."""
        return np.interp(rows, self.rows, self.elapsed_us)

    def knows_step_to(self, rows: Rows) -> NDArray[np.bool_]:
        """Return whether the clock ran on from the packet before each of these to it."""
        after = np.searchsorted(self.rows, rows)
        inside = (after > 0) & (after < len(self.rows))
        return np.asarray(inside & ~np.isin(after, self.restarts), dtype=np.bool_)


def clock_field(kind: MessageType) -> tuple[str, int] | None:
    """Return the field that tells the sender's own time, and its unit in us; None without one."""
    units = {field.name: field.unit for field in kind.fields}
    name = next((name for name in CLOCK_FIELDS if units.get(name) in MICROSECONDS), None)
    return None if name is None else (name, MICROSECONDS[units[name]])


def clock_of(rows: Rows, told_us: Floats) -> BootClock | None:
    """Return the clock that told these times at these packets; None where it is none."""
    if float(told_us.max()) > LATEST_US:
        return None
    steps = np.diff(told_us)
    wraps = (steps < -RESTART_US) & (steps + WRAP_US >= 0) & (steps + WRAP_US < LEAP_US)
    steps = np.where(wraps, steps + WRAP_US, steps)
    back = steps < -RESTART_US
    strange = int(np.count_nonzero(back | (steps > LEAP_US)))
    if strange > max(1, MAX_STRANGE_SHARE * len(steps)):
        return None
    forward = np.where((steps < 0) | (steps > LEAP_US), 0.0, steps)
    return BootClock(
        rows=rows,
        elapsed_us=np.r_[0.0, np.cumsum(forward)],
        first_us=float(told_us[0]),
        restarts=np.flatnonzero(back) + 1,
    )


def told_us(table: Table) -> Floats | None:
    """Return what the sender's clock said in each message, us; None where they carry no time."""
    field = clock_field(table.type)
    if field is None or not len(table):
        return None
    return table[field[0]].astype(np.float64) * field[1]


def table_clock(table: Table) -> BootClock | None:
    """Return the clock in the messages of one type and one sender; None where they carry none."""
    told = told_us(table)
    return None if told is None else clock_of(table.row, told)


def clocked_names(names: Iterable[str]) -> list[str]:
    """Return which of these messages, the most frequent first, tell a clock since boot best."""
    held = list(names)
    usual = [name for name in CLOCKED if name in held]
    return usual or [name for name in held if _tells_clock(name)][:MAX_CLOCKED]


def _tells_clock(name: str) -> bool:
    msgid = ids_by_name().get(name)  # none of what is kept raw, nor of a vehicle's own topics
    known = None if msgid is None else message_type(msgid)
    return known is not None and clock_field(known) is not None


def restart_rows(tables: Iterable[Table], systems: set[int]) -> dict[int, list[tuple[int, int]]]:
    """Return for each system when an autopilot of it started again: between which two packets.

    Tables are asked for one by one, until the clock of each of `systems` has been read.
    """
    found: dict[int, list[tuple[int, int]]] = {}
    left = set(systems)
    for table in tables:
        for sender in tally(table.packets.sender):
            left.discard(sender >> 8)
            clock = table_clock(table.take(table.packets.sender == sender))
            if clock is not None and len(clock.restarts):
                before, after = clock.rows[clock.restarts - 1], clock.rows[clock.restarts]
                places = zip(before.tolist(), after.tolist(), strict=True)
                found.setdefault(sender >> 8, list(places))
        if not left:
            break
    return found


def main_clock(source: ByteSource, packets: Packets, min_rows: int) -> BootClock | None:
    """Return the clock that one sender tells most often in one message; None without any.

    It has to be told at least `min_rows` times.
    """
    keys, counts = np.unique(
        packets.msgid.astype(np.int64) << 16 | packets.sender, return_counts=True
    )
    often = counts >= min_rows
    keys, counts = keys[often], counts[often]
    for key in keys[np.argsort(-counts, kind="stable")].tolist():
        known = message_type(key >> 16)
        field = None if known is None else clock_field(known)
        if known is None or field is None:
            continue
        rows = np.flatnonzero((packets.msgid == known.id) & (packets.sender == key & 0xFFFF))
        payloads = gather(source, {known.id: (packets.take(rows), known.size)})[known.id]
        told = payloads.reshape(-1).view(known.dtype)[field[0]].astype(np.float64)
        clock = clock_of(rows, told * field[1])
        if clock is not None and (len(rows) == 1 or clock.elapsed_us[-1] > 0):
            return clock
    return None
