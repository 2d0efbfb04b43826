"""Command: CSV, Parquet, or MCAP for Foxglove."""

import importlib
import json
from argparse import Namespace
from pathlib import Path

from flightstack.logs.columns.reading import read
from flightstack.logs.commands.arguments import names_in, writing
from flightstack.logs.errors import LogFileError

ENDINGS = {"csv": "", "parquet": "", "mcap": ".mcap"}  # of the default output beside the log


def _format(arguments: Namespace) -> str:
    """Return the format: as given, or by the output's ending."""
    if arguments.format:
        return str(arguments.format)
    ending = arguments.output.suffix.lstrip(".").lower() if arguments.output else ""
    if ending not in ENDINGS:
        raise LogFileError("say --format csv, parquet or mcap, or -o FILE.mcap")
    return str(ending)


def run(arguments: Namespace) -> int:
    """Write the log in another format and say where."""
    kind = _format(arguments)
    types = names_in(arguments.types) or None
    log = read(arguments.log, types=types, system=arguments.system)
    default = Path(arguments.log).with_suffix(ENDINGS[kind] or f".{kind}")
    output: Path = arguments.output or default
    writer = importlib.import_module(f"flightstack.logs.export.{kind}")
    with writing(output):
        options = {"raw_cells": arguments.raw_cells} if kind == "csv" else {}
        written = getattr(writer, f"write_{kind}")(log, output, **options)
    if arguments.json:
        print(json.dumps({"written": [str(path) for path in written], "messages": len(log)}))
    else:
        files = f"{len(written)} files" if len(written) != 1 else "one file"
        print(f"wrote {len(log)} messages to {output} ({files})")
    return 0
