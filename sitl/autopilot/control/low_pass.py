"""The first-order low pass that the controllers filter derivatives with."""

import math

from sitl.clock import TICK_S


def low_pass_gain(cutoff_hz: float) -> float:
    """Gain per tick, 0..1; a cutoff of 0 lets everything through."""
    return 1.0 - math.exp(-2.0 * math.pi * cutoff_hz * TICK_S) if cutoff_hz > 0.0 else 1.0
