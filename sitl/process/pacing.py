"""Hold vehicle time and wall time together: real time, scaled, or as fast as possible."""

import logging
from collections.abc import Callable

RESYNCHRONISE_S = 0.5  # behind by more, the lost time is given up

_log = logging.getLogger(__name__)


class Pace:
    """Say when a tick is due on the wall clock."""

    def __init__(self, speed_factor: float, clock: Callable[[], float]) -> None:
        """Pace by `speed_factor` seconds of vehicle time per second; 0: as fast as possible."""
        self._speed_factor = speed_factor
        self._clock = clock
        self._wall_s = 0.0
        self._vehicle_us = 0
        self._warned = False
        self.restart(0)

    @property
    def is_unlimited(self) -> bool:
        """Whether it is as fast as possible: every tick is due."""
        return self._speed_factor == 0.0

    def restart(self, time_us: int) -> None:
        """Let vehicle time `time_us` be now."""
        self._wall_s = self._clock()
        self._vehicle_us = time_us

    def wait_s(self, time_us: int) -> float:
        """Give how long it is until vehicle time `time_us`; 0 if it is due."""
        if self._speed_factor == 0.0:
            return 0.0
        due_s = self._wall_s + (time_us - self._vehicle_us) / 1e6 / self._speed_factor
        wait_s = due_s - self._clock()
        if wait_s < -RESYNCHRONISE_S:
            self._report(-wait_s)
            self.restart(time_us)
        return max(0.0, wait_s)

    def _report(self, late_s: float) -> None:
        level = logging.DEBUG if self._warned else logging.WARNING
        _log.log(level, "too slow for the speed factor: %.1f s behind, given up", late_s)
        self._warned = True
