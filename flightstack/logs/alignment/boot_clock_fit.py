"""Fit the times of a log to the vehicle's boot clock: offset and rate of its fastest packets.

A packet is logged late by what the link takes, never early: in each stretch of the log the one that
is least late tells the offset, and how it changes tells how much faster one clock runs.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

STRETCH_US = 4_000_000
MIN_STRETCHES = 5  # fewer tell no rate
ROUNDS = 4

Floats = NDArray[np.float64]
Times = NDArray[np.int64]


class BootClockFit(NamedTuple):
    """The log's time as a straight line over the vehicle's boot time."""

    origin_us: int  # boot time at which the offset holds
    offset_us: float  # the log's time minus the boot time, there
    rate: float  # by how much the log's clock runs faster

    def log_us(self, boot_us: Times | Floats) -> Floats:
        """Return the log's times of boot times."""
        late = self.offset_us + self.rate * (boot_us - self.origin_us)
        return np.asarray(boot_us + late, dtype=np.float64)

    def boot_us(self, log_us: Times | Floats) -> Floats:
        """Return the boot times of the log's times."""
        since = (log_us - self.origin_us - self.offset_us) / (1 + self.rate)
        return np.asarray(self.origin_us + since, dtype=np.float64)


def fit_boot_clock(log_us: Times, boot_us: Times) -> BootClockFit:
    """Return the line under all packets; `boot_us` increases, and there is at least one."""
    origin = int(boot_us[0])
    late = (log_us - boot_us).astype(np.float64)
    base = float(late.min())
    stretch = (boot_us - origin) // STRETCH_US
    starts = np.flatnonzero(np.diff(stretch, prepend=-1))
    if len(starts) < MIN_STRETCHES:
        return BootClockFit(origin, base, 0.0)
    since = (boot_us - origin).astype(np.float64)
    rate = 0.0
    for _ in range(ROUNDS):  # which packet of a stretch is least late depends on the rate
        beyond = late - base - rate * since
        parts = np.split(beyond, starts[1:])
        rows = [start + int(part.argmin()) for start, part in zip(starts, parts, strict=True)]
        rate = float(np.polyfit(since[rows], late[rows] - base, 1)[0])
    return BootClockFit(origin, base + float((late - base - rate * since).min()), rate)


def lateness_us(clock: BootClockFit, log_us: Times, boot_us: Times) -> Floats:
    """Return how late each packet was logged, beyond the fastest."""
    return np.asarray(log_us - clock.log_us(boot_us), dtype=np.float64)
