"""Write a log as MCAP for Foxglove: a channel a message type and source, messages as JSON."""

import json
import math
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from flightstack.libraries import load_library
from flightstack.logs.columns.log import Log
from flightstack.logs.columns.table import Table
from flightstack.logs.dialect.message_types import Field

CHUNK = 50_000  # packets that are decoded at once


def _field_schema(field: Field, kind: str) -> dict[str, Any]:
    about = " ".join(part for part in (field.unit and f"[{field.unit}]", field.enum) if part)
    element = {"type": "string" if field.is_text else "number" if kind == "f" else "integer"}
    schema: dict[str, Any] = {"type": "array", "items": element} if field.length else element
    return {**schema, "description": about} if about else schema


def json_schema(table: Table) -> bytes:
    """Return a message type as JSON Schema."""
    properties = {
        field.name: _field_schema(field, table.data.dtype[field.name].base.kind)
        for field in table.fields
    }
    return json.dumps({"title": table.name, "type": "object", "properties": properties}).encode()


def _finite(value: Any) -> Any:
    """Return a value that JSON can hold: NaN and infinity become null."""
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return [_finite(each) for each in value] if isinstance(value, list) else value


class _Channels:
    """Registers a schema a type and a channel a type and source when they are first seen."""

    def __init__(self, writer: Any) -> None:
        self._writer = writer
        self._schemas: dict[str, int] = {}
        self._channels: dict[tuple[str, int, int], int] = {}

    def of(self, table: Table, system: int, component: int) -> int:
        key = (table.name, system, component)
        if key not in self._channels:
            if table.name not in self._schemas:
                self._schemas[table.name] = self._writer.register_schema(
                    name=f"mavlink.{table.name}", encoding="jsonschema", data=json_schema(table)
                )
            self._channels[key] = self._writer.register_channel(
                topic=f"/{system}/{component}/{table.name}",
                message_encoding="json",
                schema_id=self._schemas[table.name],
            )
        return self._channels[key]


def _messages(part: Log) -> list[tuple[int, Table, tuple[int, int, int, int], bytes]]:
    """Return the messages of a part in order: row, table, (time, system, component, seq), JSON."""
    found = []
    for name in part.counts:
        table = part[name]
        columns = (table.time_us, table.system, table.component, table.sequence)
        heads = zip(*(np.asarray(column).tolist() for column in columns), strict=True)
        for row, head, values in zip(table.row.tolist(), heads, table.rows(), strict=True):
            data = dict(zip(table.names, map(_finite, values), strict=True))
            found.append((row, table, head, json.dumps(data).encode()))
    return sorted(found, key=lambda each: each[0])


def _pieces(parts: Iterable[Log]) -> Iterator[Log]:
    for log in parts:
        for start in range(0, len(log), CHUNK):
            yield log.rows(slice(start, start + CHUNK))


def write_mcap(parts: Iterable[Log], path: Path) -> list[Path]:
    """Write the log as one file and return its path."""
    mcap = load_library("mcap.writer", "logs")
    with path.open("wb") as file:
        writer = mcap.Writer(file)
        writer.start(profile="", library="flightstack")
        channels = _Channels(writer)
        for part in _pieces(parts):
            part.load(part.counts)
            for _, table, (time_us, system, component, sequence), data in _messages(part):
                writer.add_message(
                    channel_id=channels.of(table, system, component),
                    log_time=max(time_us, 0) * 1000,
                    publish_time=max(time_us, 0) * 1000,
                    sequence=sequence,
                    data=data,
                )
        writer.finish()
    return [path]
