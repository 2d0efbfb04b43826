"""What a trained perception is: the shape of its encoder and how its posterior is sampled."""

from dataclasses import dataclass
from typing import Literal

from flightstack.perception.labels import LabelScale

Sampling = Literal["mc-dropout", "gaussian", "mean"]
FEATURES = 512  # what the encoder's trunk hands to its head, through the dropout slot: 2 x 2 x 128


@dataclass(frozen=True, slots=True, kw_only=True)
class PerceptionConfig:
    """The perception part of a model's configuration."""

    latent_dims: int  # Z
    dropout: float  # rate of the slot after the trunk; 0 for the plain CM-VAE
    sampling: Sampling
    samples: int  # M
    within: bool = True  # with mc-dropout: also draw z ~ N(mu_m, sigma_m^2) in each pass (eq. 1)
    label_scale: LabelScale

    def __post_init__(self) -> None:
        """Refuse what contradicts itself."""
        if self.latent_dims < 4 or self.samples < 1:
            raise ValueError("latent_dims must be at least 4 and samples at least 1")
        if not 0.0 <= self.dropout < 1.0:
            raise ValueError(f"dropout must lie in [0, 1), got {self.dropout}")
        if self.sampling == "mc-dropout" and self.dropout == 0.0:
            raise ValueError("sampling 'mc-dropout' needs dropout above 0")
        if self.sampling == "mean" and self.samples != 1:
            raise ValueError(f"sampling 'mean' has 1 sample, not {self.samples}")
