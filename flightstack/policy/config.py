"""What a trained policy is: its members, their size and the units of their outputs."""

from dataclasses import dataclass, field

from flightstack.policy.scales import VelocityRange


@dataclass(frozen=True, slots=True, kw_only=True)
class PolicyConfig:
    """The policy part of a model's configuration."""

    members: int  # N
    probabilistic: bool  # mean and variance, or the mean alone
    hidden: tuple[int, ...] = (256, 64)
    velocity_range: VelocityRange = field(default_factory=VelocityRange)

    def __post_init__(self) -> None:
        """Refuse what cannot be built."""
        if self.members < 1 or len(self.hidden) != 2 or min(self.hidden) < 1:
            raise ValueError("policy: members must be at least 1 and hidden two positive sizes")
