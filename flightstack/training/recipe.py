"""Recipes: TOML files that say what is trained on what, and explain their choices.

A recipe of this package goes by its name, one of yours by its path. Yours may begin with
`base = "strong"`: then it says only what is different.
"""

import math
import re
from dataclasses import dataclass, field, replace
from importlib.resources import files
from pathlib import Path
from typing import Any, Literal, Self

import numpy as np

from flightstack.errors import UsageError
from flightstack.tables import read_toml, record_from_table, table_text
from flightstack.training.hyperparameters import NO_WISHES, Training
from flightstack.training.scene_recipe import SceneRecipe, packaged_scenes
from sitl import Scenery, SitlError, parse_conditions

RECIPE_FILE = "recipe.toml"  # in the folder of a model
FOLDER_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]*")


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


PLAIN = Scenery()
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
    scenery: Scenery = PLAIN

    def __post_init__(self) -> None:
        """Check what the type alone does not."""
        seen_deg = self.scenery.field_of_view_deg / 2.0
        for name in ("azimuth", "elevation"):
            if (drawn_deg := math.degrees(getattr(self, f"{name}_rad"))) >= seen_deg:
                raise ValueError(
                    f"{name}_deg, {drawn_deg:g}, must be below {seen_deg:g}, half of the scenery's "
                    "field of view: a gate outside of the image cannot be labelled"
                )


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
    scenery: Scenery = PLAIN

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
    """How to make the data, and how to train on them."""

    name: str  # of the folders of its data, runs and models
    views: ViewRecipe
    flights: FlightRecipe
    dagger: Dagger | None = None
    training: Training = NO_WISHES
    scenes: SceneRecipe = field(default_factory=lambda: SceneRecipe.read(packaged_scenes()))

    @classmethod
    def load(cls, name: str) -> Self:
        """Read a recipe of this package, or the file that a name ending in `.toml` is.

        Raises:
            UsageError: the recipe is unknown, or a key of it is missing, unknown or ill typed.

        """
        path = Path(name)
        if path.suffix != ".toml":
            return cls.parse(name, _packaged(name))
        try:
            text = path.read_text()
        except (OSError, UnicodeDecodeError) as error:
            raise UsageError(f"recipe {path}: can't be read: {error}") from error
        return cls.parse(path.stem, text, folder=path.parent)

    @classmethod
    def beside(cls, model: Path, name: str) -> Self:
        """Read the recipe in a model's folder; without one it is of this package, by its name."""
        own = model / RECIPE_FILE
        return cls.load(str(own) if own.is_file() else name)

    @classmethod
    def parse(cls, name: str, text: str, folder: Path = Path()) -> Self:
        """Build a recipe from TOML text; pictures are found from `folder`.

        Its [fog] lies over views and flights alike, its [scenery] under scenes as well. Raises
        UsageError.
        """
        where = f"recipe {name}"
        try:
            table = _with_base(read_toml(text, where=where), where)
            name = _folder_name(table.pop("name", name))
            if "fog" in table:
                fog = {"fog": table.pop("fog")}
                table |= {kind: fog | table[kind] for kind in ("views", "flights") if kind in table}
            _set_scenery(table, where, folder)
            return record_from_table(cls, table, where=where, given={"name": name})
        except ValueError as error:
            raise UsageError(str(error)) from error

    def text(self) -> str:
        """Write it as TOML, with all that its base said, so that it can be read anywhere."""
        return table_text(self)


def _packaged(name: str) -> str:
    """Return the text of a recipe of this package; raises UsageError."""
    folder = files("flightstack.training") / "recipes"
    file = folder / f"{name}.toml"
    if not file.is_file():
        known = ", ".join(sorted(f.name.removesuffix(".toml") for f in folder.iterdir()))
        raise UsageError(
            f"recipe '{name}': unknown; known are: {known}; one of yours is named by its file, "
            "which ends in .toml"
        )
    return file.read_text()


def _with_base(table: dict[str, Any], where: str) -> dict[str, Any]:
    """Lay a table over the recipe that it names as its base, if it does."""
    base = table.pop("base", None)
    if base is None:
        return table
    if not isinstance(base, str):
        raise ValueError(f"{where}: base: expected the name of a recipe, got {base!r}")  # noqa: TRY004
    return _over(read_toml(_packaged(base), where=base), table)


def _set_scenery(table: dict[str, Any], where: str, folder: Path) -> None:
    """Give views, flights and scenes the scenery that they, or the recipe as a whole, ask for."""
    if isinstance(table.get("scenes"), dict) or "scenery" in table:
        table["scenes"] = packaged_scenes() | table.get("scenes", {})
    common = table.pop("scenery", None)
    for kind in ("views", "flights", "scenes"):
        part = table.get(kind)
        if isinstance(part, dict) and (asked := part.get("scenery", common)) is not None:
            table[kind] = part | {"scenery": _read_scenery(asked, where, folder)}


def _read_scenery(table: object, where: str, folder: Path) -> Scenery:
    """Read a scenery as the vehicle does; raises ValueError."""
    try:
        scenery = parse_conditions({"scenery": table}, where).scenery
    except SitlError as error:
        raise ValueError(str(error)) from error
    return replace(
        scenery,
        gate_pictures=tuple(str((folder / path).resolve()) for path in scenery.gate_pictures),
        ground_pictures=tuple(str((folder / path).resolve()) for path in scenery.ground_pictures),
    )


def _over(below: dict[str, Any], above: dict[str, Any]) -> dict[str, Any]:
    merged = dict(below)
    for key, value in above.items():
        old = merged.get(key)
        if isinstance(old, dict) and isinstance(value, dict):
            merged[key] = _over(old, value)
        else:
            merged[key] = value
    return merged


def _folder_name(name: object) -> str:
    """Return the name of a recipe, which names folders; raises ValueError."""
    if not isinstance(name, str) or not FOLDER_NAME.fullmatch(name):
        raise ValueError(
            f"recipe name {name!r}: a name of letters, digits, '-', '_' and '.', since folders "
            "are called so"
        )
    return name
