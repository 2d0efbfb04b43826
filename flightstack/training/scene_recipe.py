"""The ranges that a detector's scenes are drawn from; detector/recipe.toml explains them."""

from dataclasses import dataclass
from importlib.resources import files
from typing import Any, Self

from flightstack.tables import read_toml, record_from_table
from sitl import Scenery

Span = tuple[float, float]
PLAIN = Scenery()


@dataclass(frozen=True, slots=True, kw_only=True)
class SceneRecipe:
    """The ranges that scenes are drawn from; `recipe.toml` explains them."""

    range_m: Span
    most_gates: int
    azimuth_rad: float
    elevation_rad: float
    gate_yaw_std_rad: float
    gate_yaw_uniform_share: float
    tilt_rad: float
    height_m: Span
    pair_share: float
    pair_gap_m: Span
    crowd_share: float
    empty_share: float
    noise_share: float
    noise_std: Span
    bad_noise_share: float
    bad_noise_std: Span
    blur_share: float
    blur_std_px: Span
    bad_blur_share: float
    bad_blur_std_px: Span
    dusk_share: float
    daylight: Span
    fog_share: float
    visibility_m: Span
    scenery: Scenery = PLAIN

    @classmethod
    def read(cls, table: dict[str, Any]) -> Self:
        """Read a recipe's [scenes]; raises ValueError."""
        return record_from_table(cls, table, where="scenes")


def packaged_scenes() -> dict[str, Any]:
    """Read what this package draws, and what a recipe that says less leaves as it is."""
    text = (files("flightstack.training.detector") / "recipe.toml").read_text()
    return read_toml(text, where="recipe.toml")
