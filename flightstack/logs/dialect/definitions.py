"""What pymavlink's dialect says of every message, in plain values.

The dialect is pymavlink's "all": what PX4, ArduPilot and the ground stations send. Importing it
takes longer than reading a log of ten minutes, so what is needed of it is kept in the user's cache
folder ($XDG_CACHE_HOME, else ~/.cache), for as long as the dialect's file has the same size and
time. Without a folder that can be written to, or a home, the dialect is imported each time.
"""

import importlib
import os
from functools import cache
from importlib.util import find_spec
from typing import Any, NamedTuple
from zlib import crc32

NUMPY_FORMATS = {
    "b": "i1",
    "B": "u1",
    "h": "<i2",
    "H": "<u2",
    "i": "<i4",
    "I": "<u4",
    "q": "<i8",
    "Q": "<u8",
    "f": "<f4",
    "d": "<f8",
}
FORMAT = 4  # of the cache's file; raise it when Definition changes
DIALECT = "dialects/v20/all.py"
VERSION_1 = "pymavlink.dialects.v10.all"  # the same messages without their extensions


class Definition(NamedTuple):
    """One message. Its fields are parsed where they are asked for: few logs hold many messages."""

    name: str
    crc_extra: int
    size: int  # bytes of an untrimmed payload, extensions included
    base_size: int  # the same without extensions, as version 1 sends it
    wire: str  # name:format:count,... as the fields lie on the wire; format is numpy's
    fields: str  # name:unit:enum:is_bitmask:is_text:length,... in the order of the definition

    def wire_values(self) -> list[tuple[str, str, int]]:
        """Return name, numpy format and number of elements of each field on the wire."""
        return [(name, kind, int(count)) for name, kind, count in _values(self.wire)]

    def field_values(self) -> list[tuple[str, str, str, bool, bool, int]]:
        """Return the values of dialect.Field of each field in the order of the definition."""
        return [
            (name, unit, enum, is_bitmask == "1", is_text == "1", int(length))
            for name, unit, enum, is_bitmask, is_text, length in _values(self.fields)
        ]


def _values(text: str) -> list[list[str]]:
    return [part.split(":") for part in text.split(",") if part]


def _text(values: list[list[Any]]) -> str:
    return ",".join(":".join(map(str, part)) for part in values)


def mavlink() -> Any:
    """Return pymavlink's dialect, imported when it is first asked for."""
    return importlib.import_module("pymavlink.dialects.v20.all")


def _wire(definition: Any) -> list[list[Any]]:
    codes = definition.native_format.decode().lstrip("<")
    wire = []
    fields = zip(definition.ordered_fieldnames, codes, definition.array_lengths, strict=True)
    for name, code, length in fields:
        is_text = code == "c"
        numpy_format = f"S{max(length, 1)}" if is_text else NUMPY_FORMATS[code]
        wire.append([name, numpy_format, 1 if is_text else max(length, 1)])
    return wire


def _fields(definition: Any) -> list[list[Any]]:
    lengths = dict(zip(definition.ordered_fieldnames, definition.array_lengths, strict=True))
    return [
        [
            name,
            definition.fieldunits_by_name.get(name, ""),
            definition.fieldenums_by_name.get(name, ""),
            int(definition.fielddisplays_by_name.get(name) == "bitmask"),
            int(kind == "char"),
            0 if kind == "char" or lengths[name] == 1 else lengths[name],
        ]
        for name, kind in zip(definition.fieldnames, definition.fieldtypes, strict=True)
    ]


def from_pymavlink() -> dict[int, Definition]:
    """Return the definitions as the dialect has them, by id."""
    first = importlib.import_module(VERSION_1).mavlink_map
    return {
        msgid: Definition(
            name=definition.msgname,
            crc_extra=definition.crc_extra,
            size=definition.unpacker.size,
            base_size=first.get(msgid, definition).unpacker.size,
            wire=_text(_wire(definition)),
            fields=_text(_fields(definition)),
        )
        for msgid, definition in mavlink().mavlink_map.items()
    }


def _dialect_stamp() -> list[Any]:
    """Return what changes when the dialect's file does."""
    spec = find_spec("pymavlink")
    folders = [] if spec is None else spec.submodule_search_locations or []
    path = os.path.join(next(iter(folders), ""), DIALECT)  # noqa: PTH118  # a Path takes longer
    status = os.stat(path)  # noqa: PTH116
    return [FORMAT, path, status.st_size, status.st_mtime_ns]


def cache_file() -> str:
    """Return where the definitions are kept; a relative path where the user has no home."""
    folder = os.environ.get("XDG_CACHE_HOME") or "~/.cache"
    return os.path.expanduser(f"{folder}/flightstack/definitions.txt")  # noqa: PTH111


def _head(stamp: list[Any], lines: str) -> str:
    return "\t".join(map(str, (*stamp, crc32(lines.encode())))) + "\n"


def _kept(stamp: list[Any]) -> dict[int, Definition] | None:
    """Return the definitions in the cache, None where there are none of this dialect."""
    try:
        with open(cache_file(), encoding="utf-8") as file:  # noqa: PTH123
            head, lines = file.readline(), file.read()
        if head != _head(stamp, lines):
            return None
    except (OSError, ValueError):
        return None  # none yet, or not what was written: they are made anew
    kept = {}
    for line in lines.splitlines():
        msgid, name, crc_extra, size, base, wire, fields = line.split("\t")
        kept[int(msgid)] = Definition(name, int(crc_extra), int(size), int(base), wire, fields)
    return kept


def _keep(definitions: dict[int, Definition], stamp: list[Any]) -> None:
    """Write the cache as a whole, so that another process never reads half of it."""
    rows = ((msgid, *definition) for msgid, definition in definitions.items())
    lines = "".join("\t".join(map(str, row)) + "\n" for row in rows)
    path = cache_file()
    if not os.path.isabs(path):  # noqa: PTH117
        return
    part = f"{path}.{os.getpid()}"
    try:
        os.makedirs(os.path.dirname(path), exist_ok=True)  # noqa: PTH103, PTH120
        with open(part, "w", encoding="utf-8") as file:  # noqa: PTH123
            file.write(_head(stamp, lines) + lines)
        os.replace(part, path)  # noqa: PTH105
    except OSError:
        return  # it is only slower without


@cache
def definitions() -> dict[int, Definition]:
    """Return the definition of every message of the dialect, by id."""
    try:
        stamp = _dialect_stamp()
    except OSError:
        return from_pymavlink()
    kept = _kept(stamp)
    if kept is None:
        kept = from_pymavlink()
        _keep(kept, stamp)
    return kept
