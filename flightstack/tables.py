"""Frozen records from TOML tables and back; an unknown or missing key is an error."""

import json
import math
import sys
import tomllib
import types
import typing
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, fields, is_dataclass
from typing import Any, TypeVar

Record = TypeVar("Record")
NOTHING: Mapping[str, object] = {}


def read_toml(text: str, *, where: str) -> dict[str, Any]:
    """Parse TOML; raises ValueError, in one line that begins with `where`."""
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # a number or a nesting without end, too
        raise ValueError(f"{where}: not TOML: {error}") from error


def record_from_table(
    kind: type[Record], table: object, *, where: str, given: Mapping[str, object] = NOTHING
) -> Record:
    """Build a dataclass from a table whose keys are exactly its fields (defaults may be left out).

    An angle may be given in degrees: the key `tilt_deg` fills the field `tilt_rad`. `given` are
    fields that the table may not hold, with their values. `where` names the table in errors, for
    example "config.toml: policy". Raises ValueError, in one line, for an unknown or missing key, a
    value of another type, and whatever the record refuses.
    """
    if not isinstance(table, dict):
        raise ValueError(f"{where}: expected a table, got {table!r}")  # noqa: TRY004
    known = {
        field.name: field
        for field in fields(kind)  # type: ignore[arg-type]
        if field.name not in given
    }
    keys = {key: key if key in known else _in_radians(key) for key in table}
    unknown = sorted(key for key, name in keys.items() if name not in known)
    if unknown:
        raise ValueError(f"{where}: unknown key {unknown[0]!r}; known are {', '.join(known)}")
    needed = [n for n, f in known.items() if f.default is MISSING and f.default_factory is MISSING]
    missing = [name for name in needed if name not in keys.values()]
    if missing:
        raise ValueError(f"{where}: {missing[0]!r} is missing")
    hints = typing.get_type_hints(kind)
    values = {}
    for key, name in keys.items():
        value = _convert(hints[name], table[key], where=f"{where}.{key}")
        values[name] = value if key == name else math.radians(value)
    try:
        return kind(**values, **given)
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from error


def _in_radians(key: str) -> str:
    return key.removesuffix("_deg") + "_rad" if key.endswith("_deg") else key


def _convert(kind: Any, value: Any, *, where: str) -> Any:
    """Check one value against a field's type; whole numbers pass for floats, lists for tuples."""
    origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if origin is types.UnionType:  # "Dagger | None": a key that is there is no None
        kind = arguments[0]
        origin, arguments = typing.get_origin(kind), typing.get_args(kind)
    if is_dataclass(kind) and isinstance(kind, type):
        if isinstance(value, kind):  # somebody else has read it
            return value
        return record_from_table(kind, value, where=where)
    if origin is typing.Literal:
        if value not in arguments:
            choices = ", ".join(map(repr, arguments))
            raise ValueError(f"{where}: expected one of {choices}, got {value!r}")
        return value
    if origin is tuple and isinstance(value, list):
        return _tuple(arguments, value, where)
    if kind is float and type(value) is int and abs(value) <= sys.float_info.max:
        return float(value)
    if type(value) is not kind or (kind is float and not math.isfinite(value)):
        name = getattr(kind, "__name__", str(kind))
        raise ValueError(f"{where}: expected {name}, got {value!r}")
    return value


def _tuple(kinds: tuple[Any, ...], values: list[Any], where: str) -> tuple[Any, ...]:
    """Convert each of a list; `tuple[float, ...]` takes any number of them."""
    if kinds[-1] is Ellipsis:
        kinds = (kinds[0],) * len(values)
    if len(values) != len(kinds):
        raise ValueError(f"{where}: expected {len(kinds)} numbers, got {values}")
    return tuple(
        _convert(kind, value, where=where) for kind, value in zip(kinds, values, strict=True)
    )


def table_text(record: Any) -> str:
    """Write a record as TOML: plain fields first, then one table a nested record; no None."""
    return "\n".join(_lines(record, prefix="")).lstrip("\n") + "\n"


def _lines(record: Any, *, prefix: str) -> Iterator[str]:
    values = {field.name: getattr(record, field.name) for field in fields(record)}
    values = {name: value for name, value in values.items() if value is not None}
    for name, value in values.items():
        if not is_dataclass(value):
            yield f"{name} = {_literal(value)}"
    for name, value in values.items():
        if is_dataclass(value):
            yield f"\n[{prefix}{name}]"
            yield from _lines(value, prefix=f"{prefix}{name}.")


def _literal(value: Any) -> str:
    if isinstance(value, tuple):
        return f"[{', '.join(map(_literal, value))}]"
    return json.dumps(value)  # strings, numbers and truth values read alike in TOML
