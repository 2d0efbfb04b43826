"""Keep how long answers took, in memory that a flight of any length does not fill."""

from array import array
from collections.abc import Iterator

MAX_KEPT = 1 << 16  # at 20 Hz all of the first 54 minutes, then every second, every fourth, ...


class Latencies:
    """Every one of a short flight, evenly chosen ones of a long flight; seconds of wall time."""

    def __init__(self) -> None:
        self._kept = array("d")
        self._every = 1
        self._count = 0

    def __len__(self) -> int:
        """Say how many there were, kept or not."""
        return self._count

    def __iter__(self) -> Iterator[float]:
        """Give those that were kept."""
        return iter(self._kept)

    def append(self, latency_s: float) -> None:
        """Take the next."""
        if self._count % self._every == 0:
            self._kept.append(latency_s)
            if len(self._kept) > MAX_KEPT:
                self._kept = self._kept[::2]
                self._every *= 2
        self._count += 1
