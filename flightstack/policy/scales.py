"""The units of a policy: velocities and latents, scaled to what networks like."""

from dataclasses import dataclass

import numpy as np

from flightstack.arrays import Labels, PerVelocity
from flightstack.records import VELOCITIES


@dataclass(frozen=True, slots=True, kw_only=True)
class VelocityRange:
    """What -1 and 1 of the network's outputs mean; also the limits of every command.

    The defaults are those of Bonatti et al. 2020 (see networks/dronet.py).
    """

    low: tuple[float, ...] = (-1.0, -3.0, -3.0, -1.0)  # m/s, m/s, m/s, rad/s
    high: tuple[float, ...] = (7.0, 3.0, 3.0, 1.0)

    def __post_init__(self) -> None:
        """Check once."""
        if len(self.low) != len(VELOCITIES) or len(self.high) != len(VELOCITIES):
            raise ValueError(f"VelocityRange: expected {len(VELOCITIES)} lows and highs")
        if any(low >= high for low, high in zip(self.low, self.high, strict=True)):
            raise ValueError(f"VelocityRange: low {self.low} must lie below high {self.high}")

    @property
    def offset(self) -> PerVelocity:
        """The middle of each range."""
        return np.asarray((np.array(self.high) + self.low) / 2.0)

    @property
    def scale(self) -> PerVelocity:
        """Half of each range's width."""
        return np.asarray((np.array(self.high) - self.low) / 2.0)

    def encode(self, velocities: Labels) -> Labels:
        """Map velocities in m/s and rad/s to network units."""
        return np.asarray((velocities - self.offset) / self.scale, dtype=np.float32)

    def clip(self, command: PerVelocity) -> PerVelocity:
        """Keep a command inside the ranges."""
        return np.clip(command, self.low, self.high)
