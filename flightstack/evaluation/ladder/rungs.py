"""The ladder's rungs: named conditions, each a TOML file that says what it does to whom.

A rung says how far gates are off their places, which way the course turns, a factor on commands,
and under [conditions] what the vehicle is told by `--condition` (docs/conditions.md).
"""

import math
import tomllib
from dataclasses import dataclass
from importlib.resources import files
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any, Literal

from flightstack.errors import UsageError
from flightstack.evaluation.trials.experiment import Condition
from flightstack.tables import record_from_table
from sitl import MAX_HEIGHT_NOISE_M, MAX_RADIUS_NOISE_M, SitlError, parse_conditions

CLIMB = (  # from the first rung up: what a reader of the ladder sees from left to right
    *("level1", "level2", "noise-2-4", "noise-3-5", "commands-1.6", "commands-2"),
    *("latency-100ms", "latency-200ms", "frozen-frames", "blur", "pixel-noise"),
    *("fog", "dusk", "darkness", "wind", "rotor-noise"),
    *("anticlockwise", "double-gates", "double-gates-outside"),
)
SUFFIX = ".toml"
MOST_NOISE_M = (MAX_RADIUS_NOISE_M, MAX_HEIGHT_NOISE_M)


@dataclass(frozen=True, slots=True, kw_only=True)
class Rung:
    """What a rung's file says, apart from the vehicle's conditions."""

    about: str  # one line for a reader
    noise_m: tuple[float, float]  # of the gates' radius and height
    direction: Literal["cw", "ccw"] = "cw"
    command_factor: float = 1.0


def load_rung(name: str) -> tuple[Rung, Condition]:
    """Load a rung by its name, or by the path of a TOML file, which then names it.

    Raises:
        UsageError: there is no such rung, or its file says what cannot be.

    """
    is_path = name.endswith(SUFFIX)
    file: Traversable = Path(name) if is_path else _folder() / f"{name}{SUFFIX}"
    if name not in known_rungs() and not (is_path and file.is_file()):
        raise UsageError(
            f"unknown rung {name!r}: choose from {', '.join(known_rungs())}, or name a TOML file"
        )
    try:
        return parse_rung(Path(name).stem if is_path else name, file.read_text())
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"rung {name!r} cannot be read: {error}") from error


def parse_rung(name: str, text: str) -> tuple[Rung, Condition]:
    """Build a rung from the text of its file; raises UsageError."""
    where = f"rung {name}"
    try:
        table = tomllib.loads(text)
        conditions = table.pop("conditions", {})
        rung = record_from_table(Rung, table, where=where)
        parse_conditions(conditions, where)
    except (ValueError, SitlError) as error:
        text = str(error)
        raise UsageError(text if text.startswith(where) else f"{where}: {text}") from error
    _check(rung, where)
    condition = Condition(
        name=name,
        noise_m=rung.noise_m,
        direction=rung.direction,
        command_factor=rung.command_factor,
        vehicle_options=_options(conditions),
    )
    return rung, condition


def _check(rung: Rung, where: str) -> None:
    """Refuse what the vehicle or the companion would refuse in flight."""
    if len(rung.noise_m) != len(MOST_NOISE_M):
        raise UsageError(f"{where}: noise_m must be two numbers, got {rung.noise_m}")
    for noise_m, most_m in zip(rung.noise_m, MOST_NOISE_M, strict=True):
        if not 0.0 <= noise_m <= most_m:
            raise UsageError(f"{where}: noise_m must be from 0 to {most_m:g} here, got {noise_m}")
    if not 0.0 < rung.command_factor < math.inf:
        raise UsageError(
            f"{where}: command_factor must be a number above 0, got {rung.command_factor}"
        )


def known_rungs() -> list[str]:
    """Name the rungs that come with flightstack, from the first up."""
    names = {file.name.removesuffix(SUFFIX) for file in _folder().iterdir()}
    return [name for name in CLIMB if name in names] + sorted(names.difference(CLIMB))


def _options(conditions: dict[str, dict[str, Any]]) -> tuple[str, ...]:
    """Spell conditions out for the vehicle's command line."""
    return tuple(
        f"--condition={table}.{key}={value}"  # Python writes numbers and lists as TOML does
        for table, values in conditions.items()
        for key, value in values.items()
    )


def _folder() -> Traversable:
    return files("flightstack.evaluation.ladder") / "definitions"
