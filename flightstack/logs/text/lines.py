"""Write messages as lines of text: mavlogdump's standard form, JSON, or CSV.

The strings are those that mavlogdump.py prints. Lines are made type by type from columns, then put
in the order of the log.
"""

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.columns.log import Log
from flightstack.logs.columns.table import Table
from flightstack.logs.errors import UnknownNameError
from flightstack.logs.text import fast_text
from flightstack.printable import harmless_cell, printable

CHUNK = 6_000  # packets whose lines are made at once: a compromise between steps and caches
Text = fast_text.Lines | list[bytes]  # the lines of one type
HUNDREDTHS = fast_text.from_texts([f"{number:02d}" for number in range(100)])


class LineOptions(NamedTuple):
    """How lines look."""

    format: str = "standard"  # or "json", "csv"
    separator: str = ","
    show_source: bool = False
    show_sequence: bool = False
    csv_columns: tuple[str, ...] = ()  # MESSAGE.field; what CSV lines hold
    raw_cells: bool = False  # texts in CSV as they are, even what a spreadsheet takes for code


def _second(seconds: int) -> str:
    return time.strftime("%Y-%m-%d %H:%M:%S.", time.localtime(seconds))


def _stamps(table: Table) -> fast_text.Bytes:
    """Return local times to the hundredth, as mavlogdump writes them."""
    seconds = table.time_s
    whole = np.floor(seconds).astype(np.int64)
    changes = np.flatnonzero(np.diff(whole)) + 1
    first = np.concatenate((np.zeros(min(1, len(whole)), dtype=np.int64), changes))
    names = fast_text.from_texts([_second(each) for each in whole[first].tolist()])
    repeats = np.diff(np.append(first, len(whole)))
    hundredths = (seconds * 100.0).astype(np.int64) % 100
    return np.hstack((np.repeat(names, repeats, axis=0), HUNDREDTHS[hundredths]))


def _fields(table: Table) -> Iterator[fast_text.Part]:
    """Yield the parts that write all fields, name : value, ..."""
    for index, field in enumerate(table.fields):
        column = table[field.name]
        yield f"{', ' if index else ''}{field.name} : "
        if field.is_text:
            yield fast_text.from_texts([printable(text, keep="\t") for text in column.tolist()])
        elif field.length:
            yield from fast_text.as_list(column)
        else:
            yield column


def _standard(table: Table, options: LineOptions) -> Text:
    parts = [_stamps(table), f": {table.name} {{", *_fields(table), "}"]
    if options.show_source:
        parts += [" srcSystem=", table.system, " srcComponent=", table.component]
    if options.show_sequence:
        parts += [" seq=", table.sequence]
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
    import json  # noqa: PLC0415  # takes 2 ms

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


def _csv_cells(table: Table, field: str, options: LineOptions) -> list[str]:
    cells = [str(value) for value in table[field].tolist()]
    if not table.type.field(field).is_text or options.raw_cells:
        return cells
    return [harmless_cell(printable(cell, keep="\t")) for cell in cells]


def _csv(table: Table, options: LineOptions) -> Text:
    times = [f"{time_s:.8f}" for time_s in table.time_s.tolist()]
    empty = [""] * len(table)
    columns: list[Sequence[Any]] = [times]
    for column in options.csv_columns:
        message, _, field = column.partition(".")
        is_own = message == table.name
        columns.append(_csv_cells(table, field, options) if is_own else empty)
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
    return fast_text.beside([_stamps(table), f": {name} {{payload : ", payloads, "}\n"], len(table))


def csv_columns(parts: Iterable[Log], types: Sequence[str]) -> tuple[str, ...]:
    """Return the columns of CSV lines for the messages of a log's parts, MESSAGE.field."""
    if not types:
        raise UnknownNameError("CSV needs its columns: name the messages with --types")
    fields: dict[str, tuple[str, ...]] = {}
    for part in parts:
        for name in part.counts.keys() - fields.keys():
            if not name.startswith("UNKNOWN_"):
                fields[name] = tuple(part[name].names)
    return tuple(f"{name}.{field}" for name in sorted(fields) for field in fields[name])


def lines(log: Log, options: LineOptions) -> Iterator[bytes]:
    """Yield the lines of all packets of a log in its order, many at a time."""
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
