"""Estimate how another clock runs beside ours, from round trips over a link that jitters.

A request leaves at `sent_s`, the other end stamps it, the answer is here at `received_s`. No packet
takes less than no time, so the other clock was ahead of ours by at most stamp - sent_s, and by at
least stamp - received_s; what is left open is the round trip. MAVROS and PX4 take the middle of
each trip, and keep those of less than 10 ms; a link with more jitter than that never gives one.
Here the bounds of all trips of a window hold at once (NTP's intersection, after Marzullo), so that
the quickest packet of each direction counts, of whichever trip: the middle errs by half of what
these two differ.
"""

from collections import deque
from dataclasses import dataclass
from statistics import median

import numpy as np

from flightstack.clock import ClockLine

WINDOW_S = 10.0  # of trips whose bounds hold together
MIN_TRIPS = 5
MAX_TRIP_S = 1.0  # a longer one says too little
TOLERANCE_S = 0.01  # two trips may contradict by so much: clocks that tick, machines that stall
MARK_S = 5.0  # between two marks, through which the skew is fitted
MIN_MARKS, MAX_MARKS = 12, 60  # one minute, five minutes


@dataclass(frozen=True, slots=True, kw_only=True)
class ClockQuality:
    """How well the vehicle's clock is known."""

    offset_s: float  # the vehicle's clock minus ours
    skew_ppm: float | None  # how much faster it runs; unknown within the first minute
    round_trip_s: float  # median
    uncertainty_s: float  # whatever the link does, the offset is no further from the truth
    trips: int


@dataclass(frozen=True, slots=True)
class _Trip:
    sent_s: float
    remote_s: float
    received_s: float

    @property
    def middle_s(self) -> float:
        return (self.sent_s + self.received_s) / 2

    def bounds_s(self, at_s: float, skew: float) -> tuple[float, float]:
        """Least and greatest offset at another time, if the clock runs by this skew."""
        drift_s = skew * (at_s - self.middle_s)
        return self.remote_s - self.received_s + drift_s, self.remote_s - self.sent_s + drift_s


class ClockOffset:
    """Take trips one by one; what contradicts the newest is forgotten: the clock has jumped."""

    def __init__(self) -> None:
        self._trips: deque[_Trip] = deque()
        self._marks: deque[tuple[float, float]] = deque(maxlen=MAX_MARKS)  # our time, offset: s
        self._skew = 0.0

    def add(self, sent_s: float, remote_s: float, received_s: float) -> None:
        """Take a round trip, all in seconds: sent and received by our clock."""
        if not 0.0 <= received_s - sent_s <= MAX_TRIP_S:
            return
        new = _Trip(sent_s, remote_s, received_s)
        known = len(self._trips)
        fits = (trip for trip in self._trips if self._agree(trip, new))
        self._trips = deque(t for t in fits if received_s - t.received_s <= WINDOW_S)
        if known >= MIN_TRIPS and not self._trips:
            self.begin_anew()
        self._trips.append(new)
        self._mark(received_s)

    def begin_anew(self) -> None:
        """Forget everything: the other clock is another one."""
        self._trips.clear()
        self._marks.clear()
        self._skew = 0.0

    def line(self) -> ClockLine | None:
        """Return how the other clock runs; None until enough trips agree."""
        if len(self._trips) < MIN_TRIPS:
            return None
        at_s = self._trips[-1].received_s
        lower, upper = self._bounds_s(at_s)
        return ClockLine(at_s, (at_s + (lower + upper) / 2) * 1e6, 1.0 + self._skew)

    def quality(self) -> ClockQuality | None:
        """Say how good the line is; None where there is none."""
        if len(self._trips) < MIN_TRIPS:
            return None
        lower, upper = self._bounds_s(self._trips[-1].received_s)
        return ClockQuality(
            offset_s=(lower + upper) / 2,
            skew_ppm=1e6 * self._skew if len(self._marks) >= MIN_MARKS else None,
            round_trip_s=median(t.received_s - t.sent_s for t in self._trips),
            uncertainty_s=abs(upper - lower) / 2,
            trips=len(self._trips),
        )

    def _agree(self, trip: _Trip, new: _Trip) -> bool:
        lower, upper = trip.bounds_s(new.middle_s, self._skew)
        new_lower, new_upper = new.bounds_s(new.middle_s, self._skew)
        return max(lower, new_lower) - min(upper, new_upper) <= TOLERANCE_S

    def _bounds_s(self, at_s: float) -> tuple[float, float]:
        bounds = [trip.bounds_s(at_s, self._skew) for trip in self._trips]
        return max(lower for lower, _ in bounds), min(upper for _, upper in bounds)

    def _mark(self, now_s: float) -> None:
        """Note the offset now and then; once there are enough notes, fit the skew."""
        if len(self._trips) < MIN_TRIPS or (self._marks and now_s - self._marks[-1][0] < MARK_S):
            return
        lower, upper = self._bounds_s(now_s)
        self._marks.append((now_s, (lower + upper) / 2))
        if len(self._marks) >= MIN_MARKS:
            times, offsets = np.array(self._marks).T
            self._skew = float(np.polyfit(times - times[0], offsets - offsets[0], 1)[0])
