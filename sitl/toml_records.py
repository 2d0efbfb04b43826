"""Read TOML into frozen records of numbers: every key known, every number within its limits.

The fields of a record are the keys of its table: numbers, texts, lists, and tables, which are
records again. What has a default may be left out.
"""

import math
import tomllib
from collections.abc import Mapping
from dataclasses import MISSING, fields, is_dataclass
from typing import Any, Literal, TypeVar, get_args, get_origin, get_type_hints

from sitl.errors import UsageError

Limits = tuple[float, float]  # the lowest and the highest number that may be
ANY: Limits = (-math.inf, math.inf)
POSITIVE: Limits = (math.ulp(0.0), math.inf)
NOT_NEGATIVE: Limits = (0.0, math.inf)

T = TypeVar("T")


def parse_toml(text: str, where: str) -> dict[str, Any]:
    """Read a text into tables; raises UsageError, which begins with `where`."""
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # a number or a nesting without end, too
        raise UsageError(f"{where}: not TOML: {error}") from None


def read_record(
    kind: type[T], table: Mapping[str, Any], limits: Mapping[str, Limits], where: str
) -> T:
    """Build a record; `limits` are by key, and whatever is not there may be any number.

    Raises:
        UsageError: a key is unknown or missing, or a value can't be; begins with `where`.

    """
    hints = get_type_hints(kind)
    for key, value in table.items():
        if key not in hints:
            noun = "table" if isinstance(value, dict) else "key"
            raise UsageError(f"{where}{key}: unknown {noun}; known are {', '.join(hints)}")
    for item in fields(kind):  # type: ignore[arg-type]
        if item.name not in table and item.default is MISSING:
            raise UsageError(f"{where}{item.name}: missing")
    values = {key: _read(hints[key], value, limits, (where, key)) for key, value in table.items()}
    try:
        return kind(**values)
    except UsageError as error:
        raise UsageError(f"{where}{error}") from None


def _read(hint: Any, value: Any, limits: Mapping[str, Limits], place: tuple[str, str]) -> Any:
    where, key = place
    if is_dataclass(hint) or get_origin(hint) is Mapping:
        if not isinstance(value, dict):
            raise UsageError(f"{where}{key}: must be a table, got {value!r}")
        if isinstance(hint, type):
            return read_record(hint, value, limits, f"{where}{key}.")
        return {name: _number(item, ANY, f"{where}{key}.{name}") for name, item in value.items()}
    parts = get_args(hint)
    if hint is str or get_origin(hint) is Literal:
        return _text(value, parts, f"{where}{key}")
    if parts and parts[-1] is Ellipsis:
        if not isinstance(value, list):
            raise UsageError(f"{where}{key}: must be a list, got {value!r}")
        return tuple(_read(parts[0], item, limits, place) for item in value)
    if not parts:
        return _number(value, limits.get(key, ANY), f"{where}{key}")
    if not isinstance(value, list) or len(value) != len(parts):
        noun = "lists" if get_args(parts[0]) else "numbers"
        raise UsageError(f"{where}{key}: must be {len(parts)} {noun}, got {value!r}")
    return tuple(_read(part, item, limits, place) for part, item in zip(parts, value, strict=True))


def _text(value: Any, choices: tuple[Any, ...], name: str) -> str:
    if choices and value not in choices:
        raise UsageError(f"{name}: must be one of {', '.join(choices)}, got {value!r}")
    if not isinstance(value, str):
        raise UsageError(f"{name}: must be a text, got {value!r}")
    return value


def _number(value: Any, limits: Limits, name: str) -> float:
    low, high = limits
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    if not is_number or not low <= value <= high:  # also refuses NaN
        allowed = "above 0" if limits == POSITIVE else f"from {low:g} to {high:g}"
        raise UsageError(f"{name}: must be a number {allowed}, got {value!r}")
    return float(value)
