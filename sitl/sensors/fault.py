"""What a failed sensor gives: nothing, the same for ever, chance, or its samples changed."""

from collections import deque
from collections.abc import Iterator

from sitl.records.failures import DELAY_US, SLOWER, FailureType, is_gone

# Assumption: a filter needs this long to find out that samples make no sense. Missing ones it sees
# at once, slow and late ones it goes on using.
DETECTION_US = 1_000_000
SENSELESS = {FailureType.STUCK, FailureType.GARBAGE, FailureType.WRONG}

Numbers = tuple[float, ...]


class Fault:
    """Stands between one sensor and who reads it."""

    def __init__(
        self, kind: FailureType, *, size: float, noise: Iterator[float], time_us: int
    ) -> None:
        """`size` is how large garbage and a wrong offset are, in the sensor's unit."""
        self._kind = kind
        self._size = size
        self._noise = noise
        self._since_us = time_us
        self._count = 0
        self._waiting: deque[tuple[int, Numbers]] = deque()

    def pass_on(self, sample: Numbers, time_us: int) -> Numbers | None:
        """Give what leaves the sensor for a sample; None where nothing does."""
        kind = self._kind
        given: Numbers | None = None  # off and stuck
        if kind is FailureType.GARBAGE:
            given = tuple(self._size * next(self._noise) for _ in sample)
        elif kind is FailureType.WRONG:
            given = tuple(number + self._size for number in sample)
        elif kind is FailureType.SLOW:
            self._count += 1
            given = sample if self._count % SLOWER == 0 else None
        elif kind is FailureType.DELAYED:
            self._waiting.append((time_us, sample))
            if time_us - self._waiting[0][0] >= DELAY_US:
                given = self._waiting.popleft()[1]
        elif kind is FailureType.INTERMITTENT and not is_gone(self._since_us, time_us):
            given = sample
        return given

    def is_missing(self, time_us: int) -> bool:
        """Whether there is nothing at all now, rather than something old."""
        if self._kind is FailureType.INTERMITTENT:
            return is_gone(self._since_us, time_us)
        return self._kind is FailureType.OFF

    def share(self, value: float, last: float, time_us: int) -> float:
        """Give what becomes of a share, 0..1: 0 where it is missing, else the last that came."""
        given = self.pass_on((value,), time_us)
        if given is None:
            return 0.0 if self.is_missing(time_us) else last
        return min(abs(given[0]), 1.0)

    def is_detected(self, time_us: int) -> bool:
        """Whether the estimator does without this sensor now."""
        if self._kind in SENSELESS:
            return time_us - self._since_us >= DETECTION_US
        return self.is_missing(time_us)
