"""Recipes of training data: TOML files that explain their choices, read into checked records."""

import math
from dataclasses import dataclass
from importlib.resources import files
from typing import Literal, Self

import numpy as np

from flightstack.errors import UsageError
from flightstack.tables import read_toml, record_from_table


@dataclass(frozen=True, slots=True, kw_only=True)
class Fog:
    """How often there is fog, and how thick; a recipe without that table has none."""

    share: float  # of the views, and of the flights
    visibility_m: tuple[float, float]  # drawn log-uniformly

    def __post_init__(self) -> None:
        """Check what the type alone does not."""
        if not 0.0 <= self.share <= 1.0:
            raise ValueError(f"share must be from 0 to 1, got {self.share}")
        low, high = self.visibility_m
        if not 0.0 < low <= high:
            raise ValueError(f"visibility_m [{low}, {high}] is not in order above 0")

    def draw_visibility_m(self, rng: np.random.Generator) -> float:
        """Draw how far one sees; infinite without fog."""
        if self.share == 0.0 or rng.random() >= self.share:  # without fog nothing is drawn
            return math.inf
        return math.exp(float(rng.uniform(*np.log(self.visibility_m))))


NO_FOG = Fog(share=0.0, visibility_m=(1.0, 1.0))


@dataclass(frozen=True, slots=True, kw_only=True)
class ViewRecipe:
    """The ranges that gate views are drawn from."""

    range_m: tuple[float, float]
    range_uniform: bool = False  # else log-uniform
    azimuth_rad: float  # +-
    elevation_rad: float  # +-
    gate_yaw_rad: float  # +-, for the uniform share
    gate_yaw_std_rad: float  # for the rest
    gate_yaw_uniform_share: float
    tilt_rad: float  # +- roll and pitch
    height_m: tuple[float, float]  # camera above ground
    most_distractors: int
    distractor_gap_m: tuple[float, float]  # how much farther than the labelled gate
    blur_share: float
    blur_std_px: tuple[float, float]
    noise_share: float
    noise_std: float  # of 255
    fog: Fog = NO_FOG


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightRecipe:
    """Which courses the expert flies, from where, and how much it is disturbed."""

    expert: Literal["funnel", "minimum-jerk"]
    most_radius_noise_m: float
    most_height_noise_m: float
    frames: int  # of one flight
    start_at_spawn_share: float  # the rest starts before a random gate
    start_ahead_m: tuple[float, float]
    start_spread_m: float  # standard deviation across the axis, at the farthest start
    start_yaw_std_rad: float
    calm_share: float  # of the flights, flown without execution noise
    noise_std: tuple[float, float, float, float]  # m/s, m/s, m/s, rad/s
    noise_time_constant_s: float
    lost_frames: int  # dropped before a collision or a miss
    held_out_radius_noise_m: tuple[float, float] = (0.0, 0.0)  # never drawn, from low to high
    fog: Fog = NO_FOG

    def __post_init__(self) -> None:
        """Check what the type alone does not."""
        low, high = self.held_out_radius_noise_m
        if not 0.0 <= low <= high <= self.most_radius_noise_m:
            raise ValueError(
                f"held_out_radius_noise_m [{low}, {high}] does not lie in order "
                f"between 0 and {self.most_radius_noise_m}"
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class Dagger:
    """A round of flights that a first model steers, for policies to learn from beside the expert's.

    Reference: Ross et al. 2011, "A reduction of imitation learning and structured prediction to
    no-regret online learning".
    """

    images_share: float  # of as many images as the expert's flights have

    def __post_init__(self) -> None:
        """Check what the type alone does not."""
        if not 0.0 < self.images_share <= 10.0:
            raise ValueError(f"images_share must be above 0, up to 10, got {self.images_share}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Recipe:
    """How to make the data."""

    name: str
    views: ViewRecipe
    flights: FlightRecipe
    dagger: Dagger | None = None

    @classmethod
    def load(cls, name: str) -> Self:
        """Read `recipes/<name>.toml`.

        Raises:
            UsageError: the recipe is unknown, or a key of it is missing, unknown or ill typed.

        """
        folder = files("flightstack.training") / "recipes"
        file = folder / f"{name}.toml"
        if not file.is_file():
            known = ", ".join(sorted(f.name.removesuffix(".toml") for f in folder.iterdir()))
            raise UsageError(f"recipe '{name}': unknown; known are: {known}")
        return cls.parse(name, file.read_text())

    @classmethod
    def parse(cls, name: str, text: str) -> Self:
        """Build a recipe from TOML text; its [fog] lies over views and flights alike."""
        try:
            table = read_toml(text, where=f"recipe {name}")
            if "fog" in table:
                fog = {"fog": table.pop("fog")}
                table |= {kind: fog | table[kind] for kind in ("views", "flights") if kind in table}
            return record_from_table(cls, table, where=f"recipe {name}", given={"name": name})
        except ValueError as error:
            raise UsageError(str(error)) from error
