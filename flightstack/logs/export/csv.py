"""Write each message type as a CSV file: time, source, then its fields, arrays one column each."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from flightstack.logs.columns.log import Log
from flightstack.logs.columns.table import Table
from flightstack.logs.text import fast_text
from flightstack.printable import harmless_cell

CHUNK = 8_000
QUOTED = (",", '"', "\n", "\r")


def header(table: Table) -> list[str]:
    """Return the names of a table's CSV columns."""
    names = ["time_s", "system", "component", "sequence"]
    for field in table.fields:
        elements = range(field.length)
        names += [f"{field.name}[{i}]" for i in elements] if field.length else [field.name]
    return names


def _quoted(text: str) -> str:
    if not any(mark in text for mark in QUOTED):
        return text
    return '"' + text.replace('"', '""') + '"'


def _harmless(text: str) -> str:
    return _quoted(harmless_cell(text))


def rows(table: Table, *, raw_cells: bool = False) -> bytes:
    """Return the rows of a table as CSV; raw cells may be formulas to a spreadsheet."""
    cell = _quoted if raw_cells else _harmless
    whole, rest = np.divmod(table.time_us, 1_000_000)
    micros = fast_text.from_texts([f"{part:06d}" for part in rest.tolist()])
    parts: list[fast_text.Part] = [whole, ".", micros]
    for number in (table.system, table.component, table.sequence):
        parts += [",", number]
    for field in table.fields:
        column = table[field.name]
        if field.is_text:
            parts += [",", fast_text.from_texts([cell(text) for text in column.tolist()])]
        elif field.length:
            for index in range(field.length):
                parts += [",", column[:, index]]
        else:
            parts += [",", column]
    return fast_text.text_of(fast_text.beside([*parts, "\n"], len(table)))


def write_csv(parts: Iterable[Log], folder: Path, *, raw_cells: bool = False) -> list[Path]:
    """Write one file a message type into a folder and return their paths."""
    folder.mkdir(parents=True, exist_ok=True)
    written: dict[str, Path] = {}
    for log in parts:
        for name in log.counts:
            table = log[name]
            is_new = name not in written
            path = written.setdefault(name, folder / f"{name}.csv")
            with path.open("wb" if is_new else "ab") as file:
                if is_new:
                    file.write((",".join(header(table)) + "\n").encode())
                for start in range(0, len(table), CHUNK):
                    some = table.take(slice(start, start + CHUNK))
                    file.write(rows(some, raw_cells=raw_cells))
    return list(written.values())
