"""Write messages as lines of text: mavlogdump's standard form, JSON, or CSV.

The strings are those that mavlogdump.py prints. Lines are made type by type from columns, then put
in the order of the log.
"""

import json
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flightstack.logs import fast_text
from flightstack.logs.errors import UnknownNameError
from flightstack.logs.log import Log
from flightstack.logs.table import Table

CHUNK = 8_000  # frames whose lines are in memory at once
Text = fast_text.Bytes | list[bytes]  # the lines of one type: as a matrix, or each by itself
HUNDREDTHS = fast_text.from_texts([f"{number:02d}" for number in range(100)])


@dataclass(frozen=True, slots=True, kw_only=True)
class LineOptions:
    """How lines look."""

    format: str = "standard"  # or "json", "csv"
    separator: str = ","
    show_source: bool = False
    show_sequence: bool = False
    csv_columns: tuple[str, ...] = ()  # MESSAGE.field; what CSV lines hold


def _stamps(table: Table) -> fast_text.Bytes:
    """Return local times to the hundredth, as mavlogdump writes them."""
    seconds = table.time_s
    whole, place = np.unique(np.floor(seconds).astype(np.int64), return_inverse=True)
    hundredths = (seconds * 100.0).astype(np.int64) % 100
    names = [time.strftime("%Y-%m-%d %H:%M:%S.", time.localtime(s)) for s in whole.tolist()]
    return np.hstack((fast_text.from_texts(names)[place], HUNDREDTHS[hundredths]))


def _standard(table: Table, options: LineOptions) -> Text:
    parts: list[fast_text.Bytes | str] = [_stamps(table), f": {table.name} {{"]
    for index, name in enumerate(table.names):
        parts += [f"{', ' if index else ''}{name} : ", fast_text.from_column(table[name])]
    parts.append("}")
    if options.show_source:
        system, component = map(fast_text.from_numbers, (table.system, table.component))
        parts += [" srcSystem=", system, " srcComponent=", component]
    if options.show_sequence:
        parts += [" seq=", fast_text.from_numbers(table.sequence)]
    return fast_text.beside([*parts, "\n"], len(table))


def _encoded(lines: list[str]) -> list[bytes]:
    return [line.encode(errors="replace") + b"\n" for line in lines]


def _as_lines(text: Text) -> list[bytes]:
    return text if isinstance(text, list) else fast_text.lines_of(text)


def _in_order(texts: list[Text], places: list[NDArray[np.intp]]) -> bytes:
    """Return the lines of several types in the order of the log."""
    if len(texts) == 1:
        only = texts[0]
        return b"".join(only) if isinstance(only, list) else fast_text.text_of(only)
    lines = [line for text in texts for line in _as_lines(text)]
    return b"".join([lines[row] for row in np.argsort(np.concatenate(places)).tolist()])


def _json(table: Table, options: LineOptions) -> Text:
    lines = []
    times = table.time_s.tolist()
    senders = zip(table.system.tolist(), table.component.tolist(), strict=True)
    for time_s, sender, row in zip(times, senders, table.rows(), strict=True):
        meta: dict[str, Any] = {"type": table.name, "timestamp": time_s}
        if options.show_source:
            meta["srcSystem"], meta["srcComponent"] = sender
        data = dict(zip(table.names, row, strict=True))
        lines.append(json.dumps({"meta": meta, "data": data}))
    return _encoded(lines)


def _csv(table: Table, options: LineOptions) -> Text:
    times = [f"{time_s:.8f}" for time_s in table.time_s.tolist()]
    empty = [""] * len(table)
    columns: list[Sequence[Any]] = [times]
    for column in options.csv_columns:
        message, _, field = column.partition(".")
        columns.append(list(map(str, table[field].tolist())) if message == table.name else empty)
    rows = zip(*columns, strict=True)
    return _encoded([options.separator.join(row) for row in rows])


WRITERS: dict[str, Callable[[Table, LineOptions], Text]] = {
    "standard": _standard,
    "json": _json,
    "csv": _csv,
}


def _unknown_lines(log: Log, name: str) -> Text:
    """Return lines for a message that is in no definition: its bytes."""
    table = log[name]
    payloads = fast_text.from_texts([payload.hex() for payload in log.payloads(name)])
    parts: list[fast_text.Bytes | str] = [_stamps(table), f": {name} {{payload : ", payloads, "}\n"]
    return fast_text.beside(parts, len(table))


def csv_columns(log: Log, types: Sequence[str]) -> tuple[str, ...]:
    """Return the columns of CSV lines for these types, MESSAGE.field."""
    if not types:
        raise UnknownNameError("CSV needs its columns: name the messages with --types")
    names = [name for name in log.counts if not name.startswith("UNKNOWN_")]
    return tuple(f"{name}.{field}" for name in sorted(names) for field in log[name].names)


def lines(log: Log, options: LineOptions) -> Iterator[bytes]:
    """Yield the lines of all frames of a log in its order, many at a time."""
    write = WRITERS[options.format]
    for start in range(0, len(log), CHUNK):
        part = log.rows(slice(start, start + CHUNK))
        part.load(part.counts)
        texts: list[Text] = []
        places = []
        for name in part.counts:
            is_known = len(part[name].names) > 0
            if is_known or options.format == "standard":
                texts.append(write(part[name], options) if is_known else _unknown_lines(part, name))
                places.append(part[name].row)
        if texts:
            yield _in_order(texts, places)
