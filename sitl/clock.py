"""Vehicle time: integer microseconds since boot, in ticks, and schedules that never drift."""

from fractions import Fraction

TICK_US = 4000  # 250 Hz, physics and control
SECOND_US = 1_000_000
TICK_S = TICK_US / SECOND_US


class Schedule:
    """A stream of `rate_hz`: due on the first tick at or after k / rate, k = 0, 1, 2, ...

    Exact integer arithmetic: 20 Hz on 4 ms ticks is 12 or 13 ticks apart and never drifts.
    """

    def __init__(self, rate_hz: float | Fraction, *, start_us: int = 0) -> None:
        rate = Fraction(rate_hz).limit_denominator(1_000_000)
        if rate <= 0:
            raise ValueError(f"Schedule: rate {rate_hz} Hz must be positive")
        interval_us = SECOND_US / rate
        self._numerator, self._denominator = interval_us.numerator, interval_us.denominator
        self._start_us = start_us
        self.next_due_us = start_us

    def due(self, time_us: int) -> bool:
        """Say whether the stream is due at `time_us`; true once per due time, missed ones merge."""
        if time_us < self.next_due_us:
            return False
        count = (time_us - self._start_us) * self._denominator // self._numerator + 1
        self.next_due_us = self._start_us - (-count * self._numerator // self._denominator)
        return True
