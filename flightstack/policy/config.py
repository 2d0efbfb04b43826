"""What a trained policy is: its members, their size and the units of their outputs."""

import math
from dataclasses import dataclass, field

from flightstack.policy.scales import VelocityRange
from flightstack.records import VELOCITIES


@dataclass(frozen=True, slots=True, kw_only=True)
class PolicyConfig:
    """The policy part of a model's configuration."""

    members: int  # N
    probabilistic: bool  # mean and variance, or the mean alone
    hidden: tuple[int, ...] = (256, 64)
    mixture: int = 1  # Gaussians that each member predicts, weighted
    velocity_range: VelocityRange = field(default_factory=VelocityRange)
    variance_factor: tuple[float, ...] = (1.0, 1.0, 1.0, 1.0)  # recalibrates predicted variances
    best_member: tuple[int, ...] = ()  # (4,) of each velocity on validation data, where known

    def __post_init__(self) -> None:
        """Refuse what cannot be built."""
        if self.members < 1 or len(self.hidden) != 2 or min(self.hidden) < 1:
            raise ValueError("policy: members must be at least 1 and hidden two positive sizes")
        if self.mixture < 1 or (self.mixture > 1 and not self.probabilistic):
            raise ValueError("policy: mixture must be at least 1, and 1 where not probabilistic")
        if len(self.variance_factor) != len(VELOCITIES) or not all(
            0.0 < factor < math.inf for factor in self.variance_factor
        ):
            raise ValueError(f"policy: variance_factor needs {len(VELOCITIES)} positive numbers")
        if self.best_member and (
            len(self.best_member) != len(VELOCITIES)
            or not all(0 <= member < self.members for member in self.best_member)
        ):
            raise ValueError(f"policy: best_member needs {len(VELOCITIES)} of the members")
