"""Tell the vehicle's time, from the stamps that its own messages and images carry.

Vehicle time is integer microseconds since the vehicle's boot. It may run at any speed, and it may
stand still: only stamps move it. Between two stamps `now_us` bridges the gap by the wall clock,
for the one purpose that needs it: stamping the images of a camera that carries no stamps.
The wall clock itself is handed on as `wall_s`: whoever has this clock needs no other.
"""

import time
from collections.abc import Callable

REBOOT_US = 5_000_000  # a stamp further back than this is a new boot, not one that comes late


class VehicleClock:
    """The newest stamp seen, and the wall; one thread observes, any thread may read."""

    def __init__(self, wall_s: Callable[[], float] = time.monotonic) -> None:
        self.wall_s = wall_s  # monotonic seconds
        self._first_us: int | None = None
        self._anchor: tuple[int, float] | None = None  # the newest stamp, and when it was seen
        self.stamp_us = 0  # the newest stamp
        self.before_restart_us: int | None = None  # the newest stamp of the boot before this one
        self.elapsed_us = 0  # since the first stamp seen; never negative, even after a reboot

    def observe(self, stamp_us: int) -> None:
        """Take a stamp; one that is slightly older than the newest changes nothing."""
        if self._anchor is not None and 0 <= self._anchor[0] - stamp_us < REBOOT_US:
            return
        if self._anchor is not None and stamp_us < self._anchor[0]:
            self.before_restart_us = self._anchor[0]
        self._set(stamp_us)

    def begin_anew(self, stamp_us: int) -> None:
        """Take the first stamp of a vehicle that has restarted, however little it goes back."""
        if self._anchor is not None and stamp_us < self._anchor[0]:
            self.before_restart_us = self._anchor[0]
            self._set(stamp_us)

    def _set(self, stamp_us: int) -> None:
        if self._first_us is None:
            self._first_us = stamp_us
        self._anchor = (stamp_us, self.wall_s())
        self.stamp_us = stamp_us
        self.elapsed_us = max(0, stamp_us - self._first_us)

    @property
    def started(self) -> bool:
        """Whether any stamp has been seen."""
        return self._anchor is not None

    def now_us(self) -> int:
        """Return the newest stamp plus the wall time since it was seen."""
        anchor = self._anchor
        if anchor is None:
            return 0
        return anchor[0] + round((self.wall_s() - anchor[1]) * 1e6)
