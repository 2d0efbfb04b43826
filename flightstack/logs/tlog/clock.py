"""Judge the stamps of a log's records: which are sound, and where the writer's clock jumps."""

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
LATEST_US = 41 * 10**14  # 2099: no later stamp is a time, nor one before 1970
MIN_STAMPED_SHARE = 0.5  # of the packets: fewer stamps are bytes that stand there by chance
MAX_DETOUR = 50  # packets between two that follow one another, without another clock to ask
MAX_DEPTH = 64  # stretches to look back for one that a stretch continues

Times = NDArray[np.int64]


class ClockJump(NamedTuple):
    """A place where time runs backwards, or leaps ahead."""

    row: int  # first packet after the jump
    time_us: int  # before the jump, on the axis of the log
    jump_us: int  # by the stamps; negative: backwards


class Stretch(NamedTuple):
    """Stamps that run on, one after another."""

    first: int  # its packets, from first to last, among those that have a plausible stamp
    last: int
    start_us: int
    end_us: int


def is_plausible(stamps: Times) -> NDArray[np.bool_]:
    """Return which stamps can be times at all."""
    return (stamps >= 0) & (stamps <= LATEST_US)


def has_stamps(stamps: Times) -> bool:
    """Return whether a log's records carry times, rather than a few bytes by chance."""
    return float(is_plausible(stamps).sum()) >= MIN_STAMPED_SHARE * len(stamps)


def is_even(stamps: Times) -> bool:
    """Return whether the stamps can be taken as they are: all are times, and none jumps."""
    if not len(stamps):
        return True
    steps = np.diff(stamps)
    if len(steps) and (int(steps.min()) < -JUMP_BACK_US or int(steps.max()) > JUMP_AHEAD_US):
        return False
    return int(stamps.min()) >= 0 and int(stamps.max()) <= LATEST_US


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
    distance = np.abs(times[rows] - median)
    at_end = (rows < MEDIAN_OF // 2) | (rows >= len(times) - MEDIAN_OF // 2)
    apart: NDArray[np.intp] = rows[distance > np.where(at_end, DAY_US, SPIKE_US)]
    return apart


def _stretches(times: Times) -> list[Stretch]:
    steps = np.diff(times)
    edges = np.flatnonzero((steps < -JUMP_BACK_US) | (steps > SPIKE_US)) + 1
    firsts, lasts = np.r_[0, edges], np.r_[edges, len(times)] - 1
    rows = zip(firsts.tolist(), lasts.tolist(), times[firsts].tolist(), times[lasts].tolist())  # noqa: B905  # all of one length
    return [Stretch(*row) for row in rows]


def _continues(stretch: Stretch, before: Stretch) -> bool:
    return -JUMP_BACK_US <= stretch.start_us - before.end_us <= JUMP_AHEAD_US


def _detours(times: Times) -> list[tuple[int, int]]:
    """Return the rows, from first to last, that stand between two stretches that are one."""
    kept: list[Stretch] = []
    found = []
    limit = max(MAX_DETOUR, int(MAX_DAMAGED_SHARE * len(times)))
    for stretch in _stretches(times):
        if kept and not _continues(stretch, kept[-1]):
            for depth in range(2, min(MAX_DEPTH, len(kept)) + 1):
                before = kept[-depth]
                if _continues(stretch, before):
                    if stretch.first - before.last - 1 <= limit:
                        found.append((before.last + 1, stretch.first - 1))
                        del kept[-depth + 1 :]
                    break
        kept.append(stretch)
    return found


def sound_stamps(stamps: Times) -> NDArray[np.bool_]:
    """Return which stamps are believed: times that fit those around them.

    A single one that stands apart, or a run of them after which the stamps go on as if it had not
    been, is damaged. Where more than a tenth stands apart, the log has several clocks: all are kept
    that are times at all.
    """
    sound = is_plausible(stamps)
    rows = np.flatnonzero(sound)
    apart = spikes(stamps[rows])
    if len(apart) > MAX_DAMAGED_SHARE * len(rows):
        return sound
    sound[rows[apart]] = False
    rows = np.flatnonzero(sound)
    for first, last in _detours(stamps[rows]):
        sound[rows[first : last + 1]] = False
    return sound


class RunningClock:
    """Tells of stamps, as they come, whether any choice of them can be taken as they are.

    So it is where each is a time, none is far behind the latest before it, and none leaps ahead.
    """

    def __init__(self) -> None:
        self._earliest_us = np.iinfo(np.int64).max
        self._latest_us = NO_TIME

    def runs_on(self, times: Times) -> bool:
        """Return whether the clock runs on through the next times, of which there is one."""
        latest = np.maximum.accumulate(times)
        np.maximum(latest, self._latest_us, out=latest)
        leap = int(np.diff(latest).max(initial=0))
        if self._latest_us != NO_TIME:
            leap = max(leap, int(latest[0]) - self._latest_us)
        self._earliest_us = min(self._earliest_us, int(times.min()))
        self._latest_us = int(latest[-1])
        latest -= times
        is_near = int(latest.max()) <= SPIKE_US // 2 and leap <= JUMP_AHEAD_US
        return is_near and self._earliest_us >= 0 and self._latest_us <= LATEST_US


def jumps(stamps: Times, axis: Times) -> list[ClockJump]:
    """Return where sound stamps jump in a way that the axis does not confirm, or leap ahead."""
    rows = np.flatnonzero(sound_stamps(stamps))
    steps = np.diff(stamps[rows])
    places = np.flatnonzero((steps < -JUMP_BACK_US) | (steps > JUMP_AHEAD_US))
    return [
        ClockJump(
            row=int(rows[place + 1]), time_us=int(axis[rows[place]]), jump_us=int(steps[place])
        )
        for place in places.tolist()
    ]
