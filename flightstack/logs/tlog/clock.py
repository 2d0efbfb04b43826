"""Mend the times of a log's records, and find where its clock jumps."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.tlog.packets import NO_TIME

SPIKE_US = 1_000_000  # a time this far from those around it, which agree, is damaged
DAY_US = 86_400_000_000
MEDIAN_OF = 5
MAX_DAMAGED_SHARE = 0.1  # of all times
JUMP_BACK_US = 1_000_000  # smaller steps back are several links written from several threads
JUMP_AHEAD_US = 60_000_000  # a minute of silence: the clock jumped, or logging paused

Times = NDArray[np.int64]


class ClockJump(NamedTuple):
    """A place where time runs backwards, or leaps ahead."""

    row: int  # first packet after the jump
    time_us: int  # before the jump
    jump_us: int  # negative: backwards


def _filled(times: Times) -> Times:
    """Return times with lost ones replaced by the last before, the first ones by the next."""
    known = times != NO_TIME
    if known.all():
        return times
    if not known.any():
        return np.zeros_like(times)
    source = np.maximum.accumulate(np.where(known, np.arange(len(times)), -1))
    source[source < 0] = int(np.argmax(known))
    filled: Times = times[source]
    return filled


def _suspects(times: Times) -> NDArray[np.intp]:
    """Return the rows on either side of every large step."""
    steps = np.diff(times)
    before = np.flatnonzero((steps > SPIKE_US) | (steps < -SPIKE_US))
    return np.unique(np.append(before, before + 1)) if len(before) else before


def spikes(times: Times) -> NDArray[np.intp]:
    """Return the rows whose time stands apart from the median of the five around it.

    Where time runs on, fast or slowly, the median is the time itself; after a jump that lasts, it
    is on the same side. At both ends, where there is no middle, only a day's distance counts.
    """
    if len(times) < MEDIAN_OF:
        return np.empty(0, dtype=np.intp)
    rows = _suspects(times)
    first = np.clip(rows - MEDIAN_OF // 2, 0, len(times) - MEDIAN_OF)
    around = times[first[:, None] + np.arange(MEDIAN_OF)]
    median = np.sort(around, axis=1)[:, MEDIAN_OF // 2]
    distance = np.abs(times[rows].astype(np.float64) - median.astype(np.float64))
    at_end = (rows < MEDIAN_OF // 2) | (rows >= len(times) - MEDIAN_OF // 2)
    return rows[distance > np.where(at_end, DAY_US, SPIKE_US)]


def mend(times: Times) -> tuple[Times, int]:
    """Return times with lost and damaged ones replaced by the last before, and how many were.

    Where more than a tenth stands apart, the log has several clocks: nothing is touched.
    """
    lost = times == NO_TIME
    filled = _filled(times)
    damaged = spikes(filled)
    if len(damaged) > MAX_DAMAGED_SHARE * len(times):
        damaged = damaged[:0]
    lost[damaged] = True
    return _filled(np.where(lost, NO_TIME, filled)), int(lost.sum())


class RunningClock:
    """Tells of times, as they come, whether `mend` would change none, whichever it was given.

    So it is where none is far behind the latest before it: of the five around a time, two before
    it cannot be much later, and two after it not much earlier, so the median is near.
    """

    def __init__(self) -> None:
        self._earliest_us = np.iinfo(np.int64).max
        self._latest_us = NO_TIME

    def runs_on(self, times: Times) -> bool:
        """Return whether the clock runs on through the next times, of which there is one."""
        latest = np.maximum.accumulate(times)
        np.maximum(latest, self._latest_us, out=latest)
        self._earliest_us = min(self._earliest_us, int(times.min()))
        self._latest_us = int(latest[-1])
        latest -= times
        is_near = int(latest.max()) <= SPIKE_US // 2
        return is_near and self._latest_us - self._earliest_us < DAY_US


def jumps(times: Times) -> list[ClockJump]:
    """Return where mended times run backwards or leap ahead."""
    if len(times) < 2:
        return []
    steps = np.diff(times)
    places = np.flatnonzero((steps < -JUMP_BACK_US) | (steps > JUMP_AHEAD_US))
    return [
        ClockJump(
            row=row + 1, time_us=int(times[row]), jump_us=int(times[row + 1]) - int(times[row])
        )
        for row in places.tolist()
    ]
