"""Command: one HTML page with all of the flight."""

import json
from argparse import Namespace
from pathlib import Path

from flightstack.logs.checks import run_checks
from flightstack.logs.commands.arguments import check_folder, writing
from flightstack.logs.commands.opening import open_flight, use_checks
from flightstack.logs.report.page import make_page


def run(arguments: Namespace) -> int:
    """Write the report and say where it is."""
    use_checks(arguments)
    check_folder(arguments.frames)
    flight = open_flight(arguments.log, arguments.system)
    page = make_page(flight, run_checks(flight), arguments.frames)
    output: Path = arguments.output or Path(arguments.log).with_suffix(".html")
    with writing(output):
        output.write_text(page, encoding="utf-8")
    print(json.dumps({"report": str(output)}) if arguments.json else f"wrote {output}")
    return 0
