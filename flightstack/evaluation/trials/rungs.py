"""The ladder's rungs: named conditions, each a TOML table that says what it does to whom.

A rung says how far gates are off their places, which way the course turns, a factor on commands,
and under [conditions] what the vehicle is told by `--condition` (docs/conditions.md).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any, Literal

from flightstack.errors import UsageError
from flightstack.evaluation.trials.experiment import Condition
from flightstack.tables import read_toml, record_from_table
from sitl import MAX_HEIGHT_NOISE_M, MAX_RADIUS_NOISE_M, SitlError, parse_conditions

SUFFIX, SCENERY = ".toml", "scenery"
MAX_NOISE_M = (MAX_RADIUS_NOISE_M, MAX_HEIGHT_NOISE_M)


@dataclass(frozen=True, slots=True, kw_only=True)
class Rung:
    """What a rung's table says, apart from the vehicle's conditions."""

    about: str  # one line for a reader
    noise_m: tuple[float, float]  # of the gates' radius and height
    direction: Literal["cw", "ccw"] = "cw"
    command_factor: float = 1.0

    def __post_init__(self) -> None:
        """Refuse what the vehicle or the companion would refuse in flight."""
        for noise_m, max_m in zip(self.noise_m, MAX_NOISE_M, strict=True):
            if not 0.0 <= noise_m <= max_m:
                raise ValueError(f"noise_m must be from 0 to {max_m:g} here, got {noise_m}")
        if self.command_factor <= 0.0:
            raise ValueError(f"command_factor must be a number above 0, got {self.command_factor}")


def load_rung(name: str) -> tuple[Rung, Condition]:
    """Load a rung by its name, or by the path of a TOML file, which then names it.

    Raises:
        UsageError: there is no such rung, or its file says what cannot be.

    """
    if name in _known():
        return make_rung(name, _known()[name])
    if not (name.endswith(SUFFIX) and Path(name).is_file()):
        raise UsageError(
            f"unknown rung {name!r}: choose from {', '.join(known_rungs())}, or name a TOML file"
        )
    try:
        return parse_rung(Path(name).stem, Path(name).read_text())
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"rung {name!r} cannot be read: {error}") from error


def parse_rung(name: str, text: str) -> tuple[Rung, Condition]:
    """Build a rung from the text of its file; raises UsageError."""
    try:
        return make_rung(name, read_toml(text, where=f"rung {name}"))
    except ValueError as error:
        raise UsageError(str(error)) from error


def make_rung(name: str, table: Mapping[str, Any]) -> tuple[Rung, Condition]:
    """Build a rung from its table; raises UsageError."""
    where = f"rung {name}"
    conditions = table.get("conditions", {})
    try:
        own = {key: value for key, value in table.items() if key != "conditions"}
        rung = record_from_table(Rung, own, where=where)
        parse_conditions(conditions, where)
    except (ValueError, SitlError) as error:
        text = str(error)
        raise UsageError(text if text.startswith(where) else f"{where}: {text}") from error
    condition = Condition(
        name=name,
        noise_m=rung.noise_m,
        direction=rung.direction,
        command_factor=rung.command_factor,
        vehicle_options=_options(conditions),
    )
    return rung, condition


def known_rungs() -> list[str]:
    """Name the rungs that come with flightstack, from the first up."""
    return list(_known())


def _options(conditions: Mapping[str, Mapping[str, Any]]) -> tuple[str, ...]:
    """Spell conditions out for the vehicle's command line.

    A scenery goes as a whole: what its keys say is checked together.
    """
    plain = {table: values for table, values in conditions.items() if table != SCENERY}
    whole = {SCENERY: conditions[SCENERY]} if SCENERY in conditions else {}
    return (
        *(
            f"--condition={table}.{key}={_toml(value)}"
            for table, values in plain.items()
            for key, value in values.items()
        ),
        *(f"--condition={table}={_toml(values)}" for table, values in whole.items()),
    )


def _toml(value: object) -> str:
    """Write a value on one line; Python writes numbers, lists and plain texts as TOML does."""
    if isinstance(value, Mapping):
        return "{" + ", ".join(f"{key} = {_toml(item)}" for key, item in value.items()) + "}"
    return str(value) if not isinstance(value, str) else repr(value)


@cache
def _known() -> dict[str, Any]:
    text = (files("flightstack.evaluation.trials") / f"rungs{SUFFIX}").read_text()
    return read_toml(text, where="rungs.toml")
