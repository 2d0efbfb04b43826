"""The conditions of a flight that is not a fine day's: wind, light, camera, course and so on.

A TOML file has a table for each; what it leaves out stays as it is on a fine day, where everything
is off and a flight is the very same as without a file. The record is the reference of the keys.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from sitl.errors import UsageError
from sitl.records.motion import Vector3
from sitl.records.scenery import PLAIN, Scenery
from sitl.toml_records import Limits, parse_toml, read_record

CALM: Vector3 = (0.0, 0.0, 0.0)
MIN_DECOY_M = 1.8  # a gate is 1.6 m wide: nearer ones would stand in each other

LIMITS: Mapping[str, Limits] = {
    "mean_ned_m_s": (-20.0, 20.0),
    "gust_std_m_s": (0.0, 5.0),
    "gust_time_constant_s": (0.1, 60.0),
    "fog_visibility_m": (1.0, math.inf),
    "daylight_share": (0.0, 1.0),
    "latency_s": (0.0, 0.4),  # a companion takes images older than 0.5 s for lost
    "blur_std_px": (0.0, 16.0),
    "noise_std_levels": (0.0, 128.0),
    "frozen_frame_share": (0.0, 1.0),
    "decoy_inwards_m": (-6.0, 6.0),
    "rotor_noise_share": (0.0, 1.0),
    "inner_m": (0.4, 4.0),
    "outer_m": (0.4, 5.0),
    "depth_m": (0.01, 1.0),
    "field_of_view_deg": (30.0, 140.0),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Wind:
    """How the air moves: a mean, and gusts about it that come and go."""

    mean_ned_m_s: Vector3 = CALM  # where it blows to
    gust_std_m_s: float = 0.0  # along each axis
    gust_time_constant_s: float = 2.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Light:
    """What the air and the hour do to the view."""

    fog_visibility_m: float = math.inf  # where 2 % of the contrast is left
    daylight_share: float = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraFaults:
    """What the camera and its wire do to the images."""

    latency_s: float = 0.0  # from the shutter to the stream; the stamp is the shutter's
    blur_std_px: float = 0.0
    noise_std_levels: float = 0.0  # of 255, each pixel and colour alone
    frozen_frame_share: float = 0.0  # of the images, which show the picture before once more


@dataclass(frozen=True, slots=True, kw_only=True)
class CourseDecoys:
    """What stands on the course beside its gates."""

    decoy_inwards_m: float = 0.0  # a second gate beside each, that far; negative: outwards; 0: none


@dataclass(frozen=True, slots=True, kw_only=True)
class EstimateErrors:
    """What makes the vehicle's estimate of its own motion worse."""

    rotor_noise_share: float = 0.0  # of the rotors' noise of PX4's simulator (SIH); 1: as there


@dataclass(frozen=True, slots=True, kw_only=True)
class Conditions:
    """Everything about a day that is not fine."""

    wind: Wind = Wind()
    light: Light = Light()
    camera: CameraFaults = CameraFaults()
    course: CourseDecoys = CourseDecoys()
    estimate: EstimateErrors = EstimateErrors()
    scenery: Scenery = PLAIN

    def __post_init__(self) -> None:
        """Check what the ranges alone do not; raises UsageError."""
        if 0.0 < abs(self.course.decoy_inwards_m) < MIN_DECOY_M:
            raise UsageError(
                f"course.decoy_inwards_m: must be 0 or at least {MIN_DECOY_M} either way, "
                f"got {self.course.decoy_inwards_m:g}"
            )


def read_conditions(file: Path | None, changes: Sequence[str] = ()) -> Conditions:
    """Read a file, if there is one, and then changes such as `camera.latency_s=0.1`.

    Raises:
        UsageError: the file can't be read, or a key or value can't be: says which, and what could.

    """
    table: dict[str, Any] = {}
    if file is not None:
        try:
            text = file.read_text()
        except (OSError, UnicodeDecodeError) as error:
            raise UsageError(f"--conditions: can't read {file}: {error}") from None
        table = parse_toml(text, f"--conditions {file}")
        parse_conditions(table, f"--conditions {file}")
    for change in changes:
        where = f"--condition {change}"
        table = _changed(table, parse_toml(change, where))
        parse_conditions(table, where)
    return parse_conditions(table, "--conditions")


def _changed(table: Mapping[str, Any], change: Mapping[str, Any]) -> dict[str, Any]:
    """Lay a change over a table, and its tables over the table's."""
    changed = dict(table)
    for key, value in change.items():
        known = changed.get(key)
        both = isinstance(known, dict) and isinstance(value, dict)
        changed[key] = _changed(known, value) if both else value  # type: ignore[arg-type]
    return changed


def parse_conditions(table: Mapping[str, Any], where: str) -> Conditions:
    """Check a table of tables; `where` names it in errors. Raises UsageError."""
    return read_record(Conditions, table, LIMITS, f"{where}: ")
