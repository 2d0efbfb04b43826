"""Frozen records from TOML tables and back; an unknown or missing key is an error."""

import json
import typing
from collections.abc import Iterator
from dataclasses import MISSING, fields, is_dataclass
from typing import Any, TypeVar

Record = TypeVar("Record")


def record_from_table(kind: type[Record], table: object, *, where: str) -> Record:
    """Build a dataclass from a table whose keys are exactly its fields (defaults may be left out).

    `where` names the table in errors, for example "config.toml: policy". Raises ValueError, in one
    line, for an unknown or missing key, a value of another type, and whatever the record refuses.
    """
    if not isinstance(table, dict):
        raise ValueError(f"{where}: expected a table, got {table!r}")  # noqa: TRY004
    known = {field.name: field for field in fields(kind)}  # type: ignore[arg-type]
    unknown = sorted(set(table) - set(known))
    if unknown:
        raise ValueError(f"{where}: unknown key {unknown[0]!r}; known are {', '.join(known)}")
    needed = [n for n, f in known.items() if f.default is MISSING and f.default_factory is MISSING]
    missing = [name for name in needed if name not in table]
    if missing:
        raise ValueError(f"{where}: {missing[0]!r} is missing")
    hints = typing.get_type_hints(kind)
    values = {
        name: _convert(hints[name], value, where=f"{where}.{name}") for name, value in table.items()
    }
    try:
        return kind(**values)
    except ValueError as error:
        raise ValueError(f"{where}: {error}") from error


def _convert(kind: Any, value: Any, *, where: str) -> Any:
    """Check one value against a field's type; whole numbers pass for floats, lists for tuples."""
    if is_dataclass(kind) and isinstance(kind, type):
        return record_from_table(kind, value, where=where)
    origin = typing.get_origin(kind)
    if origin is typing.Literal:
        if value not in typing.get_args(kind):
            choices = ", ".join(map(repr, typing.get_args(kind)))
            raise ValueError(f"{where}: expected one of {choices}, got {value!r}")
        return value
    if origin is tuple and isinstance(value, list):
        element = typing.get_args(kind)[0]
        return tuple(_convert(element, item, where=where) for item in value)
    if kind is float and type(value) is int:
        return float(value)
    if type(value) is not kind:
        name = getattr(kind, "__name__", str(kind))
        raise ValueError(f"{where}: expected {name}, got {value!r}")
    return value


def table_text(record: Any) -> str:
    """Write a record as TOML: plain fields first, then one table a nested record."""
    return "\n".join(_lines(record, prefix="")).lstrip("\n") + "\n"


def _lines(record: Any, *, prefix: str) -> Iterator[str]:
    values = {field.name: getattr(record, field.name) for field in fields(record)}
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
