"""Scale gate-pose labels to what the network predicts, and back.

A label is standardised over the training data (zero mean, unit variance), so that the squared error
of a constant predictor is 1 for each of them. Range goes through its logarithm: an error of 10 %
weighs the same near and far. Labels that a mirrored image negates keep the offset 0.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

LABELS = ("range_m", "azimuth_rad", "elevation_rad", "gate_yaw_rad")  # body FRD; see below
# azimuth: right positive; elevation: up positive; gate yaw: heading of the gate's passing axis
# relative to the body's heading, 0 = head on

RANGE = LABELS.index("range_m")
MIRRORED = np.array([1.0, -1.0, 1.0, -1.0])  # what a left-right flip of the image does to each
MIN_RANGE_M = 0.05  # floor below which the logarithm would say too much


@dataclass(frozen=True, slots=True, kw_only=True)
class LabelScale:
    """`scaled = (label - offset) / scale` per label, with the logarithm of the range."""

    offset: tuple[float, ...]  # (4,) log m, rad, rad, rad
    scale: tuple[float, ...]  # (4,)

    def __post_init__(self) -> None:
        """Check both once."""
        if len(self.offset) != len(LABELS) or len(self.scale) != len(LABELS):
            raise ValueError(f"LabelScale: expected {len(LABELS)} offsets and scales")
        if min(self.scale) <= 0.0:
            raise ValueError(f"LabelScale.scale: must be positive, got {self.scale}")

    @classmethod
    def of(cls, labels: NDArray[np.float32]) -> Self:
        """Fit to training labels with shape (K, 4)."""
        values = _with_log_range(labels)
        offset = np.where(MIRRORED < 0.0, 0.0, values.mean(axis=0))
        scale = np.sqrt(np.mean((values - offset) ** 2, axis=0))
        return cls(offset=tuple(offset.tolist()), scale=tuple(np.maximum(scale, 1e-6).tolist()))

    def encode(self, labels: NDArray[np.float32]) -> NDArray[np.float32]:
        """Map physical labels (K, 4) to scaled ones."""
        scaled = (_with_log_range(labels) - self.offset) / np.array(self.scale)
        return np.asarray(scaled, dtype=np.float32)

    def decode(self, scaled: NDArray[np.float32]) -> NDArray[np.float64]:
        """Map scaled labels (K, 4) back to metres and radians."""
        labels: NDArray[np.float64] = scaled.astype(np.float64) * self.scale + self.offset
        labels[:, RANGE] = np.exp(labels[:, RANGE])
        return labels


def _with_log_range(labels: NDArray[np.float32]) -> NDArray[np.float64]:
    values = labels.astype(np.float64)
    values[:, RANGE] = np.log(np.maximum(values[:, RANGE], MIN_RANGE_M))
    return values
