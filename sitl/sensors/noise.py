"""Draw random numbers cheaply, one by one, from a generator of one's own."""

from collections.abc import Iterator

import numpy as np

from sitl.records.motion import Vector3

BLOCK = 4096  # numbers drawn at once: one at a time would cost ten times as much


def normals(rng: np.random.Generator) -> Iterator[float]:
    """Give standard normal numbers for ever."""
    while True:
        yield from rng.standard_normal(BLOCK).tolist()


def normal_vector(rng: np.random.Generator, std: float) -> Vector3:
    """Draw a vector of independent components, as a bias that stays."""
    x, y, z = rng.normal(0.0, std, 3).tolist()
    return (x, y, z)
