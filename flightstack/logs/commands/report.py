"""Command: one HTML page with all of the flight."""

import json
from argparse import Namespace
from pathlib import Path

from flightstack.logs.checks import run_checks
from flightstack.logs.commands.opening import open_flight, use_checks
from flightstack.logs.errors import LogFileError
from flightstack.logs.report.page import make_page


def run(arguments: Namespace) -> int:
    """Write the report and say where it is."""
    use_checks(arguments)
    if arguments.frames is not None and not arguments.frames.is_dir():
        raise LogFileError(f"--frames {arguments.frames}: no such folder")
    flight = open_flight(arguments)
    page = make_page(flight, run_checks(flight), arguments.frames)
    output: Path = arguments.output or Path(arguments.log).with_suffix(".html")
    try:
        output.write_text(page, encoding="utf-8")
    except OSError as error:
        raise LogFileError(f"{output} cannot be written: {error.strerror}; use -o") from error
    print(json.dumps({"report": str(output)}) if arguments.json else f"wrote {output}")
    return 0
