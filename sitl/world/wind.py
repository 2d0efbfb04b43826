"""The air's movement: a steady wind, and gusts that come and go.

Each axis of a gust is a first-order Gauss-Markov process: in the frequency domain that is the
longitudinal spectrum of Dryden's turbulence, whose time constant is the scale length over the
air speed.

Reference: MIL-F-8785C, 1980, section 3.7.2.2.
"""

import math
from collections.abc import Iterator

from sitl.records.conditions import Wind
from sitl.records.motion import Vector3


def blow(wind: Wind, noise: Iterator[float], tick_s: float) -> Iterator[Vector3]:
    """Give the air's velocity (m/s, NED), tick by tick, for ever; `noise` is standard normal."""
    decay = math.exp(-tick_s / wind.gust_time_constant_s)
    kick = wind.gust_std_m_s * math.sqrt(1.0 - decay**2)
    north, east, down = wind.mean_ned_m_s
    x, y, z = (wind.gust_std_m_s * next(noise) for _ in range(3))
    while True:
        yield (north + x, east + y, down + z)
        x = decay * x + kick * next(noise)
        y = decay * y + kick * next(noise)
        z = decay * z + kick * next(noise)
