"""The named settings of a training: `quick` for a coffee break, `full` for a night.

A recipe's [training] goes before them, and an option of the command line before both. Settings
travel with what was trained from them: a checkpoint refuses to go on under others.
"""

from dataclasses import dataclass, field, replace

from flightstack.networks.cmvae import LossWeights
from flightstack.policy.scales import VelocityRange
from flightstack.training.hyperparameters import (
    NO_WISHES,
    Training,
    given,
)


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
    must_learn: bool = True  # else what has not learned is no error: a trial of the way


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
    must_learn: bool = True  # else what has not learned is no error: a trial of the way


IMAGES = {  # of each dataset; `full` is the paper's
    "quick": {"perception": 100_000, "control": 30_000},
    "full": {"perception": 300_000, "control": 17_000},
}
PERCEPTION_EPOCHS = {"quick": 16, "full": 10}  # 1.3 and 2.4 million views
CALIBRATION_IMAGES = {"quick": 2000, "full": 6000}
POLICY_EPOCHS = {"quick": 60, "full": 60}
ENSEMBLE_MEMBERS = 5  # paper
MCD_DROPOUT = 0.2


def images_of(preset: str, kind: str, training: Training) -> int:
    """Say how many images a dataset has, "perception" or "control"."""
    wanted = {"perception": training.perception_images, "control": training.control_images}[kind]
    return IMAGES[preset][kind] if wanted is None else wanted


def calibration_images_of(preset: str, training: Training) -> int:
    """Say how many images a finished model looks at."""
    wanted = training.calibration_images
    return CALIBRATION_IMAGES[preset] if wanted is None else wanted


def perception_settings(
    preset: str,
    *,
    encoder: str,
    seed: int,
    training: Training = NO_WISHES,
    epochs: int | None = None,
) -> PerceptionSettings:
    """Name the settings of one encoder, "mcd" or "plain"."""
    settings = PerceptionSettings(epochs=PERCEPTION_EPOCHS[preset], seed=seed, dropout=MCD_DROPOUT)
    settings = replace(settings, must_learn=training.must_learn, **given(training.perception))
    if encoder == "plain":
        settings = replace(settings, dropout=0.0)
    return settings if epochs is None else replace(settings, epochs=epochs)


def policy_settings(
    preset: str,
    *,
    kind: str,
    seed: int,
    training: Training = NO_WISHES,
    epochs: int | None = None,
) -> PolicySettings:
    """Name the settings of one stack: "ensemble", "single" or "deterministic"."""
    settings = PolicySettings(
        members=ENSEMBLE_MEMBERS,
        probabilistic=kind != "deterministic",
        epochs=POLICY_EPOCHS[preset],
        seed=seed,
    )
    settings = replace(settings, must_learn=training.must_learn, **given(training.policy))
    if kind != "ensemble":
        settings = replace(settings, members=1)
    return settings if epochs is None else replace(settings, epochs=epochs)
