"""Command: CSV, Parquet, or MCAP for Foxglove."""

import importlib
import json
from argparse import Namespace
from collections import Counter
from collections.abc import Iterator
from pathlib import Path

from flightstack.logs.columns.log import Log
from flightstack.logs.columns.reading import read
from flightstack.logs.columns.segments import is_large, logs_of
from flightstack.logs.errors import LogFileError
from flightstack.logs.given.arguments import names_in, writing

ENDINGS = {"csv": "", "parquet": "", "mcap": ".mcap"}  # of the default output beside the log


def _format(arguments: Namespace) -> str:
    """Return the format: as given, or by the output's ending."""
    if arguments.format:
        return str(arguments.format)
    ending = arguments.output.suffix.lstrip(".").lower() if arguments.output else ""
    if ending not in ENDINGS:
        raise LogFileError("say --format csv, parquet or mcap, or -o FILE.mcap")
    return str(ending)


def _parts(arguments: Namespace, counts: Counter[str]) -> Iterator[Log]:
    """Yield what is asked for, of a large log part by part; `counts` grows by it."""
    types = names_in(arguments.types) or None
    large = is_large(arguments.log)
    for part in logs_of(arguments.log) if large else [read(arguments.log, types=types)]:
        log = part.select(types=types, system=arguments.system)
        counts.update(log.counts)
        yield log


def run(arguments: Namespace) -> int:
    """Write the log in another format and say where."""
    kind = _format(arguments)
    counts: Counter[str] = Counter()
    default = Path(arguments.log).with_suffix(ENDINGS[kind] or f".{kind}")
    output: Path = arguments.output or default
    writer = importlib.import_module(f"flightstack.logs.export.{kind}")
    with writing(output):
        options = {"raw_cells": arguments.raw_cells} if kind == "csv" else {}
        written = getattr(writer, f"write_{kind}")(_parts(arguments, counts), output, **options)
    if arguments.json:
        print(json.dumps({"written": [str(path) for path in written], "messages": counts.total()}))
    else:
        files = f"{len(written)} files" if len(written) != 1 else "one file"
        print(f"wrote {counts.total()} messages to {output} ({files})")
    return 0
