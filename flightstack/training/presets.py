"""The named settings of a training: `quick` for a coffee break, `full` for a night.

Settings travel with what was trained from them: a checkpoint refuses to go on under others.
"""

from dataclasses import dataclass, field

from flightstack.networks.cmvae import LossWeights
from flightstack.policy.scales import VelocityRange


@dataclass(frozen=True, slots=True, kw_only=True)
class PerceptionSettings:
    """How to train one CM-VAE."""

    epochs: int
    seed: int = 0
    batch: int = 64
    learning_rate: float = 1e-3  # AdamW's peak; cosine to 0 after a short warm-up
    weight_decay: float = 1e-4
    warmup_steps: int = 500
    latent_dims: int = 10  # paper
    dropout: float = 0.2  # rate of the slot after the trunk; 0 for the plain CM-VAE
    image_fraction: float = 0.5  # share of a batch that the image decoder sees
    weights: LossWeights = field(default_factory=LossWeights)


@dataclass(frozen=True, slots=True, kw_only=True)
class PolicySettings:
    """How to train one stack of policies on the latents of one frozen encoder."""

    members: int
    probabilistic: bool
    epochs: int
    seed: int = 0
    batch: int = 128
    learning_rate: float = 2e-3  # AdamW's peak; cosine to 0
    weight_decay: float = 1e-4
    hidden: tuple[int, int] = (256, 64)
    bootstrap: bool = False  # each member learns from its own draw, with replacement, of the data
    velocity_range: VelocityRange = field(default_factory=VelocityRange)
    mixture: int = 1  # Gaussians of each member


IMAGES = {  # of each dataset; `full` is the paper's
    "quick": {"perception": 100_000, "control": 30_000},
    "full": {"perception": 300_000, "control": 17_000},
}
PERCEPTION_EPOCHS = {"quick": 16, "full": 10}  # 1.3 and 2.4 million views
CALIBRATION_IMAGES = {"quick": 2000, "full": 6000}
POLICY_EPOCHS = {"quick": 60, "full": 60}
ENSEMBLE_MEMBERS = 5  # paper
MCD_DROPOUT = 0.2


def perception_settings(
    preset: str, *, encoder: str, seed: int, epochs: int | None = None
) -> PerceptionSettings:
    """Name the settings of one encoder, "mcd" or "plain"."""
    return PerceptionSettings(
        epochs=PERCEPTION_EPOCHS[preset] if epochs is None else epochs,
        seed=seed,
        dropout=MCD_DROPOUT if encoder == "mcd" else 0.0,
    )


def policy_settings(
    preset: str, *, kind: str, seed: int, epochs: int | None = None
) -> PolicySettings:
    """Name the settings of one stack: "ensemble", "single" or "deterministic"."""
    return PolicySettings(
        members=ENSEMBLE_MEMBERS if kind == "ensemble" else 1,
        probabilistic=kind != "deterministic",
        epochs=POLICY_EPOCHS[preset] if epochs is None else epochs,
        seed=seed,
    )
