"""Tell the vehicle's time, from the stamps that its own messages and images carry.

Vehicle time is integer microseconds since the vehicle's boot. It may run at any speed, and it may
stand still: only stamps move it. Between two stamps `at_us` bridges the gap by the wall clock, for
the one purpose that needs it: dating the images of a camera that carries no stamps. Where the
vehicle has been asked how its clock runs (TIMESYNC), a line tells that, which no link delays.
The wall clock itself is handed on as `wall_s`: whoever has this clock needs no other.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass

REBOOT_US = 5_000_000  # a stamp further back than this is a new boot, not one that comes late
MAX_LEAD_US = 50_000  # of telemetry, which can only be late: beyond that the line is wrong


@dataclass(frozen=True, slots=True)
class ClockLine:
    """How vehicle time runs beside ours."""

    wall_s: float
    vehicle_us: float  # at that moment
    rate: float  # vehicle seconds in one of ours

    def at_us(self, wall_s: float) -> int:
        """Return the vehicle's time at one of ours."""
        return round(self.vehicle_us + (wall_s - self.wall_s) * self.rate * 1e6)


class VehicleClock:
    """The newest stamp seen, and the wall; one thread observes, any thread may read."""

    def __init__(self, wall_s: Callable[[], float] = time.monotonic) -> None:
        self.wall_s = wall_s  # monotonic seconds
        self._first_us: int | None = None
        self._anchor: tuple[int, float] | None = None  # the newest stamp, and when it was seen
        self._line: ClockLine | None = None
        self._passed_us = 0  # of others, before the first stamp
        self.stamp_us = 0  # the newest stamp
        self.before_restart_us: int | None = None  # the newest stamp of the boot before this one
        self.elapsed_us = 0  # since the first stamp seen; never negative, even after a reboot

    def observe(self, stamp_us: int) -> None:
        """Take a stamp; one that is slightly older than the newest changes nothing."""
        if self._anchor is not None and 0 <= self._anchor[0] - stamp_us < REBOOT_US:
            return
        if self._anchor is not None and stamp_us < self._anchor[0]:
            self._restart(self._anchor[0])
        self._set(stamp_us)

    def begin_anew(self, stamp_us: int) -> None:
        """Take the first stamp of a vehicle that has restarted, however little it goes back."""
        if self._anchor is not None and stamp_us < self._anchor[0]:
            self._restart(self._anchor[0])
            self._set(stamp_us)

    def forget(self) -> None:
        """Forget the clock of a vehicle that was heard by mistake; the next stamp is the first."""
        self._anchor = self._first_us = self._line = self.before_restart_us = None
        self._passed_us, self.stamp_us = self.elapsed_us, 0

    def synchronise(self, line: ClockLine | None) -> None:
        """Tell time by a line from now on; None, or one that no stamp agrees with: by stamps."""
        now_s = self.wall_s()
        odd = line is not None and self.started and self._differs(line, now_s)
        self._line = None if odd else line

    def _restart(self, before_us: int) -> None:
        self.before_restart_us = before_us
        self._line = None

    def _differs(self, line: ClockLine, now_s: float) -> bool:
        return abs(line.at_us(now_s) - self._by_stamps_us(now_s)) >= REBOOT_US

    def _set(self, stamp_us: int) -> None:
        if self._first_us is None:
            self._first_us = stamp_us
        now_s = self.wall_s()
        self._anchor = (stamp_us, now_s)
        if self._line is not None and stamp_us - self._line.at_us(now_s) > MAX_LEAD_US:
            self._line = None
        self.stamp_us = stamp_us
        self.elapsed_us = self._passed_us + max(0, stamp_us - self._first_us)

    @property
    def started(self) -> bool:
        """Whether any stamp has been seen."""
        return self._anchor is not None

    @property
    def synchronised(self) -> bool:
        """Whether the vehicle has said how its clock runs."""
        return self._line is not None

    def now_us(self) -> int:
        """Return the vehicle's time now, as far as it is known."""
        return self.at_us(self.wall_s())

    def at_us(self, wall_s: float) -> int:
        """Return the vehicle's time at a moment of the wall clock, 0 where nothing is known.

        By the line that the vehicle has told, else the newest stamp and the wall time since.
        """
        line = self._line
        return max(0, self._by_stamps_us(wall_s) if line is None else line.at_us(wall_s))

    def _by_stamps_us(self, wall_s: float) -> int:
        anchor = self._anchor
        return 0 if anchor is None else anchor[0] + round((wall_s - anchor[1]) * 1e6)
