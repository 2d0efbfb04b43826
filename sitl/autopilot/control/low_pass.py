"""The first-order low pass that the controllers filter derivatives with."""

import math
from functools import cache


@cache
def low_pass_gain(cutoff_hz: float, dt_s: float) -> float:
    """Gain a tick, 0..1; a cutoff of 0 lets everything through."""
    return 1.0 - math.exp(-2.0 * math.pi * cutoff_hz * dt_s) if cutoff_hz > 0.0 else 1.0
