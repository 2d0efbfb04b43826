"""Rounds of DAgger: a trained model flies a share of the flights, and the expert labels them."""

from dataclasses import dataclass
from pathlib import Path
from typing import Self

from flightstack.arrays import PerVelocity, SmallRgb
from flightstack.errors import UsageError
from flightstack.records import Image
from flightstack.training.data.flights import Pilot

# Imported where used: whoever renders without a pilot need not wait for torch.


@dataclass(frozen=True, slots=True, kw_only=True)
class Piloting:
    """Who flies, and how many of the flights."""

    model: str  # RECIPE/NAME
    weights_sha256: str
    share: float
    folder: Path  # where it lies, which the flights do not depend on

    def __post_init__(self) -> None:
        """Check the share."""
        if not 0.0 < self.share <= 1.0:
            raise UsageError(f"the pilot's share must be above 0 and at most 1, not {self.share}")

    @classmethod
    def by(cls, model: str, share: float) -> Self:
        """Name a model, or its folder, as the pilot; raises ModelError when there is none."""
        from flightstack import models  # noqa: PLC0415

        folder = models.find(model)
        config = models.read_config(folder / models.CONFIG_FILE)
        return cls(
            model=f"{config.recipe}/{config.name}",
            weights_sha256=config.weights_sha256,
            share=share,
            folder=folder,
        )

    def describe(self) -> dict[str, str | float]:
        """Name what the flights depend on."""
        return {
            "model": self.model,
            "weights_sha256": self.weights_sha256,
            "share": self.share,
        }

    def load(self, *, seed: int) -> Pilot:
        """Load the model, to fly by its own strategy."""
        from flightstack.companion.pipeline import load_pipeline  # noqa: PLC0415

        pipeline = load_pipeline(str(self.folder), seed=seed)

        def decide(rgb: SmallRgb) -> PerVelocity:
            return pipeline.decide(Image(stamp_us=0, sequence=0, rgb=rgb)).command

        return decide
