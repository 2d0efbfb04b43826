"""Write each message type as a Parquet file, units in the columns' metadata."""

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


def write_parquet(log: Log, folder: Path) -> list[Path]:
    """Write one file a message type into a folder and return their paths."""
    arrow, parquet = (load_library(name, "logs") for name in ("pyarrow", "pyarrow.parquet"))
    folder.mkdir(parents=True, exist_ok=True)
    written = []
    for name in log.counts:
        path = folder / f"{name}.parquet"
        parquet.write_table(_arrow_table(arrow, log[name]), path)
        written.append(path)
    return written
