"""Modes of a kernel density estimate over a few samples, for all velocities at once.

The bandwidth is Scott's: of 32 samples of one Gaussian it shows two modes one time in ten, of two
Gaussians four standard deviations apart nine times in ten.

Reference: Scott 1992, "Multivariate density estimation".
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Bool, Float32, Float64
from numpy.typing import NDArray

from flightstack.arrays import CountPerVelocity, PerVelocity

Grid = Float64[NDArray[np.float64], "4 G"]
Density = Float32[NDArray[np.float32], "4 G"]
GRID = 64  # points; a mode is located to about 1/10 of a bandwidth or better
MARGIN = 2.0  # bandwidths that the grid reaches beyond the outermost samples
MIN_HEIGHT = 0.1  # of the highest mode; a lower bump is one stray sample, not an alternative
MIN_BANDWIDTH = 1e-9  # where all samples are equal


@dataclass(frozen=True, slots=True, kw_only=True)
class Modes:
    """The modes of each velocity's density, on a grid."""

    grid: Grid  # m/s, rad/s
    density: Density  # relative
    is_mode: Bool[NDArray[np.bool_], "4 G"]

    @property
    def count(self) -> CountPerVelocity:
        """How many modes each velocity has; at least 1."""
        return np.asarray(np.count_nonzero(self.is_mode, axis=1), dtype=np.int64)

    @property
    def lowest(self) -> PerVelocity:
        """The lowest-valued mode of each velocity."""
        return self._pick(self.is_mode.argmax(axis=1))

    @property
    def highest(self) -> PerVelocity:
        """The highest-valued mode of each velocity."""
        return self._pick(GRID - 1 - self.is_mode[:, ::-1].argmax(axis=1))

    @property
    def densest(self) -> PerVelocity:
        """The mode with the greatest density."""
        return self._pick(self.density.argmax(axis=1))

    @property
    def softest(self) -> PerVelocity:
        """The mode nearest to zero."""
        return self._pick(np.where(self.is_mode, np.abs(self.grid), np.inf).argmin(axis=1))

    def _pick(self, index: CountPerVelocity) -> PerVelocity:
        return self.grid[np.arange(len(self.grid)), index]


def find_modes(values: Float64[NDArray[np.float64], "M 4"]) -> Modes:
    """Estimate the density of samples and find its modes."""
    samples = np.ascontiguousarray(values.T)  # (4, M): long rows add up fastest
    low, high = samples.min(axis=1), samples.max(axis=1)
    bandwidth = np.maximum(samples.std(axis=1) * len(values) ** -0.2, MIN_BANDWIDTH)
    low, high = low - MARGIN * bandwidth, high + MARGIN * bandwidth
    grid = low[:, np.newaxis] + (high - low)[:, np.newaxis] * _STEPS  # (4, G)
    density = _density(grid, samples, bandwidth)
    rises = density[:, 1:] > density[:, :-1]  # (4, G - 1)
    floor = MIN_HEIGHT * density.max(axis=1, keepdims=True)
    is_mode = np.zeros(density.shape, dtype=np.bool_)
    is_mode[:, 1:-1] = rises[:, :-1] & ~rises[:, 1:] & (density[:, 1:-1] >= floor)
    return Modes(grid=grid, density=density, is_mode=is_mode)


def _density(
    grid: Grid, samples: Float64[NDArray[np.float64], "4 M"], bandwidth: PerVelocity
) -> Density:
    """Sum up Gaussian kernels on the grid; single precision, because a picture needs no more."""
    unit = (1.0 / bandwidth)[:, np.newaxis]
    start = grid[:, :1]  # counted from here, so that single precision loses nothing
    at, centre = (((x - start) * unit).astype(np.float32) for x in (grid, samples))
    exponent = at[:, :, np.newaxis] - centre[:, np.newaxis]  # (4, G, M)
    np.square(exponent, out=exponent)
    exponent *= np.float32(-0.5)
    return np.asarray(np.exp(exponent, out=exponent).sum(axis=2))


_STEPS = np.linspace(0.0, 1.0, GRID)
