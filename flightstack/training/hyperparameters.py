"""What a recipe's [training] says: how much is trained, and how; the rest is the preset's."""

from dataclasses import dataclass, fields
from typing import Any

Pair = tuple[float, float]


def _require(record: Any, names: tuple[str, ...], low: float, high: float) -> None:
    """Raise ValueError where a value that is given lies outside of low to high."""
    for name in names:
        value = getattr(record, name)
        if value is not None and not low <= value <= high:
            raise ValueError(f"{name} must be from {low:g} to {high:g}, got {value:g}")


RATES = ("learning_rate", "weight_decay")
MAX_COUNT = 1e9


@dataclass(frozen=True, slots=True, kw_only=True)
class PerceptionTraining:
    """Of a CM-VAE; the fields are those of `presets.PerceptionSettings`."""

    epochs: int | None = None
    batch: int | None = None
    learning_rate: float | None = None  # AdamW's peak
    weight_decay: float | None = None
    warmup_steps: int | None = None
    latent_dims: int | None = None
    dropout: float | None = None  # of the encoder with dropout; the plain one has none
    image_fraction: float | None = None  # share of a batch that the image decoder sees

    def __post_init__(self) -> None:
        """Check what the type alone does not."""
        _require(self, ("epochs", "warmup_steps"), 1, MAX_COUNT)
        _require(self, ("batch",), 2, MAX_COUNT)
        _require(self, RATES, 0.0, 1.0)
        _require(self, ("latent_dims",), 1, 1024)
        _require(self, ("dropout",), 0.0, 0.9)
        _require(self, ("image_fraction",), 0.0, 1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class PolicyTraining:
    """Of a stack of policies; the fields are those of `presets.PolicySettings`."""

    epochs: int | None = None
    members: int | None = None  # of an ensemble; what is single stays so
    batch: int | None = None
    learning_rate: float | None = None  # AdamW's peak
    weight_decay: float | None = None
    hidden: tuple[int, int] | None = None
    bootstrap: bool | None = None  # each member draws its own data
    mixture: int | None = None  # Gaussians a member

    def __post_init__(self) -> None:
        """Check what the type alone does not."""
        _require(self, ("epochs",), 1, MAX_COUNT)
        _require(self, ("batch",), 2, MAX_COUNT)
        _require(self, ("members", "mixture"), 1, 1024)
        _require(self, RATES, 0.0, 1.0)
        if self.hidden is not None and not all(1 <= size <= 1 << 16 for size in self.hidden):
            raise ValueError(f"hidden sizes must be from 1 to 65536, got {list(self.hidden)}")


@dataclass(frozen=True, slots=True, kw_only=True)
class DetectorTraining:
    """Of a detector of sets of gates; the fields are those of `detector.trainer`'s settings."""

    epochs: int | None = None
    batch: int | None = None
    learning_rate: float | None = None  # AdamW's peak
    weight_decay: float | None = None
    warm_up_steps: int | None = None

    def __post_init__(self) -> None:
        """Check what the type alone does not."""
        _require(self, ("epochs", "warm_up_steps"), 1, MAX_COUNT)
        _require(self, ("batch",), 2, MAX_COUNT)
        _require(self, RATES, 0.0, 1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Training:
    """How many images, and how each network learns from them."""

    must_learn: bool = True  # False: a trial of the way, whatever comes out of it
    perception_images: int | None = None
    control_images: int | None = None
    calibration_images: int | None = None
    scene_files: int | None = None  # of a detector
    file_scenes: int | None = None  # in each of them
    validation_scenes: int | None = None
    perception: PerceptionTraining = PerceptionTraining()
    policy: PolicyTraining = PolicyTraining()
    detector: DetectorTraining = DetectorTraining()

    def __post_init__(self) -> None:
        """Check what the type alone does not."""
        _require(self, ("perception_images", "control_images"), 10, MAX_COUNT)
        _require(self, ("calibration_images", "file_scenes", "validation_scenes"), 1, MAX_COUNT)
        _require(self, ("scene_files",), 1, 80)


NO_WISHES = Training()


def given(record: Any) -> dict[str, Any]:
    """Name the values that a recipe gives of one of these records."""
    values = {field.name: getattr(record, field.name) for field in fields(record)}
    return {name: value for name, value in values.items() if value is not None}
