"""Scale gate-pose labels to what the network predicts, and back.

A label is standardised over the training data (zero mean, unit variance), so that the squared error
of a constant predictor is 1 for each of them. Range goes through its logarithm: an error of 10 %
weighs the same near and far. Labels that a mirrored image negates keep the offset 0.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from flightstack.arrays import Labels, PerImage

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
    def of(cls, labels: Labels) -> Self:
        """Fit to training labels."""
        values = _with_log_range(labels)
        offset = np.where(MIRRORED < 0.0, 0.0, values.mean(axis=0))
        scale = np.sqrt(np.mean((values - offset) ** 2, axis=0))
        return cls(offset=tuple(offset.tolist()), scale=tuple(np.maximum(scale, 1e-6).tolist()))

    def encode(self, labels: Labels) -> Labels:
        """Map physical labels to scaled ones."""
        scaled = (_with_log_range(labels) - self.offset) / np.array(self.scale)
        return np.asarray(scaled, dtype=np.float32)

    def decode(self, scaled: Labels) -> PerImage:
        """Map scaled labels back to metres and radians."""
        labels: PerImage = scaled.astype(np.float64) * self.scale + self.offset
        labels[:, RANGE] = np.exp(labels[:, RANGE])
        return labels


def _with_log_range(labels: Labels) -> PerImage:
    values = labels.astype(np.float64)
    values[:, RANGE] = np.log(np.maximum(values[:, RANGE], MIN_RANGE_M))
    return values
