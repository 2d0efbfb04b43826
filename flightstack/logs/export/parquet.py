"""Write each message type as a Parquet file, units in the columns' metadata."""

from collections.abc import Iterable
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np

from flightstack.libraries import load_library
from flightstack.logs.columns.log import Log
from flightstack.logs.columns.table import Table


def _arrow_table(arrow: Any, table: Table) -> Any:
    stamp = arrow.timestamp("us", tz="UTC")
    columns = [arrow.array(table.time_us, type=stamp)]
    fields = [arrow.field("time", stamp)]
    for name in ("system", "component", "sequence"):
        columns.append(arrow.array(np.ascontiguousarray(getattr(table, name))))
        fields.append(arrow.field(name, arrow.uint8()))
    for field in table.fields:
        column = table[field.name]
        if field.is_text:
            array = arrow.array(column.tolist(), type=arrow.string())
        elif field.length:
            flat = arrow.array(np.ascontiguousarray(column).reshape(-1))
            array = arrow.FixedSizeListArray.from_arrays(flat, field.length)
        else:
            array = arrow.array(np.ascontiguousarray(column))
        metadata = {"unit": field.unit, "enum": field.enum}
        known = {key: value for key, value in metadata.items() if value}
        columns.append(array)
        fields.append(arrow.field(field.name, array.type, metadata=known or None))
    return arrow.Table.from_arrays(columns, schema=arrow.schema(fields))


def write_parquet(parts: Iterable[Log], folder: Path) -> list[Path]:
    """Write one file a message type into a folder and return their paths."""
    arrow, parquet = (load_library(name, "logs") for name in ("pyarrow", "pyarrow.parquet"))
    folder.mkdir(parents=True, exist_ok=True)
    writers: dict[Path, Any] = {}
    with ExitStack() as stack:
        for log in parts:
            for name in log.counts:
                table = _arrow_table(arrow, log[name])
                path = folder / f"{name}.parquet"
                if path not in writers:
                    writer = parquet.ParquetWriter(path, table.schema)
                    writers[path] = stack.enter_context(writer)
                writers[path].write_table(table)
    return list(writers)
