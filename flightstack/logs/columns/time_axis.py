"""Make one axis of time for a log: from the stamps of who wrote it, and the autopilot's clock.

Stamps tell when a packet was written. They are missing, damaged, or jump when the writer's clock
is set; then the step from one packet to the next is what the autopilot's own clock says. The axis
never runs backwards by more than the packets of several links do, and begins where the stamps put
most of the log, since 1970; without stamps, with the autopilot's boot.
"""

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.columns.boot_clock import (
    MIN_ROWS,
    BootClock,
    main_clock,
    table_clock,
    told_us,
)
from flightstack.logs.columns.table import Table
from flightstack.logs.tlog.clock import (
    JUMP_AHEAD_US,
    JUMP_BACK_US,
    Times,
    has_stamps,
    is_even,
    sound_stamps,
)
from flightstack.logs.tlog.packets import Packets
from flightstack.logs.tlog.source import ByteSource

LONGEST_PAUSE_US = 7 * 86_400_000_000  # a longer step ahead is a clock that was set
SET_AFTER_US = 10**15  # 2001: earlier stamps are of a clock that was never set
SAME_RATE = 0.02  # by how much a clock may run faster or slower than the axis
MIN_SPAN_US = 1_000_000  # over which a rate can be told


def _steps(stamps: Times, rows: NDArray[np.intp], clock: BootClock | None) -> Times:
    """Return the steps between stamps at `rows`; where they jump, those of the clock."""
    steps = np.diff(stamps)
    strange = np.flatnonzero((steps < -JUMP_BACK_US) | (steps > JUMP_AHEAD_US))
    set_anew = (steps[strange] < 0) | (steps[strange] > LONGEST_PAUSE_US)
    instead = np.where(set_anew, 0, steps[strange])
    if clock is not None:
        known = clock.knows_step_to(rows[strange + 1])
        by_clock = clock.at(rows[strange + 1]) - clock.at(rows[strange])
        instead = np.where(known, by_clock.astype(np.int64), instead)
    steps[strange] = instead
    return steps


def _anchored(axis: Times, stamps: Times) -> Times:
    """Return the axis moved to where the stamps put most of it, those of a set clock first."""
    is_set = stamps >= SET_AFTER_US
    chosen = is_set if is_set.any() else np.ones(len(stamps), dtype=np.bool_)
    offsets = stamps[chosen] - axis[chosen]
    clusters, first, counts = np.unique(
        offsets // JUMP_BACK_US, return_index=True, return_counts=True
    )
    del clusters
    moved: Times = axis + offsets[first[counts.argmax()]]
    return moved


def _filled(axis: Times, rows: NDArray[np.intp], count: int, clock: BootClock | None) -> Times:
    """Return times for all packets from those known at `rows`: by the clock, else the last one."""
    every = np.arange(count)
    place = np.searchsorted(rows, every, side="right") - 1
    before = np.maximum(place, 0)
    times = axis[before]
    if clock is not None and len(rows) < count:
        since = clock.at(every) - clock.at(rows[before])
        latest = axis[np.minimum(before + 1, len(rows) - 1)]
        ahead = np.clip(times + since.astype(np.int64), times, np.maximum(latest, times))
        times = np.where(place >= 0, np.where(before == len(rows) - 1, times + since, ahead), times)
    times = times.astype(np.int64)
    times[rows] = axis
    return times


def _since_boot(clock: BootClock | None, count: int) -> Times:
    if clock is None:
        return np.zeros(count, dtype=np.int64)
    times = clock.first_us + clock.at(np.arange(count))
    return np.asarray(times, dtype=np.int64)


def axis_of(source: ByteSource, packets: Packets) -> Times:
    """Return the time of every packet, us: since 1970, or since boot where nothing is stamped."""
    stamps = packets.time_us
    if is_even(stamps):
        return stamps
    if not has_stamps(stamps):
        return _since_boot(main_clock(source, packets, 1), len(packets))
    clock = main_clock(source, packets, MIN_ROWS)
    rows = np.flatnonzero(sound_stamps(stamps))
    kept = stamps[rows]
    axis = np.r_[np.int64(0), np.cumsum(_steps(kept, rows, clock))]
    axis = _anchored(axis, kept)
    return _filled(axis, rows, len(packets), clock)


def measured_us(table: Table) -> Times:
    """Return when the messages of one type and one sender were measured, us, for derivatives.

    By the sender's clock, which no link delays; where they carry none, when they were logged.
    """
    clock = table_clock(table)
    if clock is None or clock.elapsed_us[-1] == 0:
        return table.time_us
    elapsed = clock.elapsed_us.copy()
    for place in clock.restarts.tolist():  # the pause is what the log says
        pause = max(int(table.time_us[place] - table.time_us[place - 1]), 0)
        elapsed[place:] += pause
    return np.asarray(table.time_us[0] + elapsed, dtype=np.int64)


def placed_us(table: Table) -> Times:
    """Return the same on the axis of the log, for what is laid beside other messages.

    Each boot is moved as a whole to where its fastest packet arrived. A clock that runs at another
    rate than the log, as in a simulation faster than time, has no place there: then when logged.
    """
    measured = measured_us(table)
    clock = table_clock(table)
    if clock is None or measured is table.time_us:
        return table.time_us
    placed = measured.copy()
    edges = [0, *clock.restarts.tolist(), len(table)]
    for first, last in pairwise(edges):
        part = slice(first, last)
        span, own = np.ptp(table.time_us[part]), np.ptp(measured[part])
        if abs(own - span) > max(SAME_RATE * span, 2 * MIN_SPAN_US):
            return table.time_us
        placed[part] += (table.time_us[part] - measured[part]).min()
    return placed


def without_copies(table: Table) -> Table:
    """Return the messages of one type and one sender once each, whatever links brought them."""
    told = told_us(table)
    if told is None or len(told) < 2:
        return table
    is_new = np.r_[True, np.diff(np.maximum.accumulate(told)) > 0] | np.r_[True, np.diff(told) < 0]
    return table if is_new.all() or not told.any() else table.take(is_new)


def restarts_of(table: Table) -> Times:
    """Return when the sender of these messages had started again, on the axis of the log."""
    clock = table_clock(table)
    return table.time_us[:0] if clock is None else table.time_us[clock.restarts]
