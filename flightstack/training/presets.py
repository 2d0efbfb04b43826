"""The named settings of a training: `quick` for a coffee break, `full` for a night.

Settings travel with what was trained from them: a checkpoint refuses to go on under others.
"""

from dataclasses import dataclass, field

from flightstack.perception.cmvae import LossWeights


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


PERCEPTION_EPOCHS = {"quick": 16, "full": 50}
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
