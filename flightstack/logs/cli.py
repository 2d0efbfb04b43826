"""The command line: python -m flightstack.logs LOG."""

import argparse
import os
import sys
from collections.abc import Callable, Iterable, Sequence
from functools import cache
from typing import TYPE_CHECKING, NamedTuple

from flightstack.arguments.parser import OptionParser
from flightstack.errors import FlightstackError
from flightstack.logs.process import imported, keep_freed_memory, single_threaded_numpy
from flightstack.printable import printable

if TYPE_CHECKING:
    from pathlib import Path

DESCRIPTION = "Inspect MAVLink logs, and the vehicle's own. A bare path gives the summary."
PROGRAM = "python -m flightstack.logs"
HELP_WIDTH = 78  # where no terminal says how wide it is


def _path(text: str) -> "Path":
    from pathlib import Path  # noqa: PLC0415  # takes 4 ms, and few need it

    return Path(text)


def _add_summary(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("paths", nargs="+", type=_path, metavar="PATH", help="logs, or folders")
    parser.add_argument("--checks", type=_path, metavar="FILE", help="your own checks, in Python")


def _add_params(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("names", nargs="*", metavar="NAME", help="names or wildcards; default all")
    parser.add_argument("--changes", action="store_true", help="only those that changed")


def _add_dump(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("--types", metavar="A,B", help="message types, comma separated, with wildcards")
    add("--nottypes", metavar="A,B", help="message types to leave out")
    add("--condition", metavar="EXPR", help='such as "ATTITUDE.roll > 0.1"')
    add("--format", choices=("standard", "json", "csv"), default="standard")
    add("--csv_sep", "--csv-sep", default=",", metavar="SEP", help="'tab' for tabs")
    add("--show-source", action="store_true", help="show system and component")
    add("--show-seq", action="store_true", help="show sequence numbers")
    add("--show-types", action="store_true", help="only list the types that match")
    add("--source-system", type=int, metavar="N")
    add("--source-component", type=int, metavar="N")
    add("--link", type=int, metavar="N", help="link number, from the low bits of the time")
    add("--reduce-rate", type=float, default=0.0, metavar="HZ", help="at most so many of a type")
    add("--from", dest="start", type=float, metavar="S", help="seconds since the log's start")
    add("--to", dest="end", type=float, metavar="S", help="seconds since the log's start")
    add("-o", "--output", type=_path, metavar="TLOG", help="write matching records to a tlog")
    add("--raw-cells", action="store_true", help="CSV: leave texts that start like formulas")
    add("-q", "--quiet", action="store_true", help="print nothing")
    add("--robust", action="store_true", help="accepted for mavlogdump's sake: always so")
    add("--no-bad-data", action="store_true", help="accepted for mavlogdump's sake: always so")


def _add_plot(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("fields", nargs="+", metavar="FIELD", help='such as ATTITUDE.roll or "degrees(VFR_HUD.x)"')
    add("-o", "--output", type=_path, metavar="FILE", help="PNG or SVG; default beside the log")
    add("--from", dest="start", type=float, metavar="S", help="seconds since the log's start")
    add("--to", dest="end", type=float, metavar="S", help="seconds since the log's start")


def _add_report(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("-o", "--output", type=_path, metavar="HTML", help="default beside the log")
    add("--with", dest="beside", type=_path, metavar="LOG", help="the vehicle's own log of it")
    add("--frames", type=_path, metavar="FOLDER", help="recorded frames; default LOG.frames")
    add("--checks", type=_path, metavar="FILE", help="your own checks, in Python")


def _add_check(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--checks", type=_path, metavar="FILE", help="your own checks, in Python")
    parser.add_argument("--strict", action="store_true", help="exit 1 if a check finds an error")


def _add_why(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("--seconds", type=float, default=2.0, metavar="S", help="how far to look back")
    add("--frames", type=_path, metavar="FOLDER", help="recorded frames; default LOG.frames")
    add("-o", "--output", type=_path, metavar="PNG", help="draw the strip")


def _add_video(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("-o", "--output", type=_path, metavar="MP4", help="default beside the log")
    add("--frames", type=_path, metavar="FOLDER", help="recorded frames; default LOG.frames")


def _add_dataset(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("paths", nargs="+", type=_path, metavar="LOG", help="logs with recorded images, or folders")
    add("-o", "--output", type=_path, required=True, metavar="FOLDER", help="new, or empty")
    add("--task", default="fly through the gates", metavar="TEXT", help="what was to be done")


def _add_export(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("--format", choices=("csv", "parquet", "mcap"), help="default: by the output's ending")
    add("-o", "--output", type=_path, metavar="PATH", help="file (MCAP) or folder (CSV, Parquet)")
    add("--types", metavar="A,B", help="message types, comma separated, with wildcards")
    add("--raw-cells", action="store_true", help="CSV: leave texts that start like formulas")


def _add_follow(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("source", metavar="LOG|LINK", help="a log being written, or udpin:0.0.0.0:14550, tcp:...")
    add("--types", metavar="A,B", help="print these messages too; default: events and rates")
    add("--seconds", type=float, default=0.0, metavar="S", help="stop after so long; 0: never")
    add("--from-start", action="store_true", help="begin at the start of the log, not its end")


def _add_compare(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("other", type=_path, metavar="OTHER")


class LogCommand(NamedTuple):
    """What the command line says of a command; its code is the module of that name."""

    about: str
    add_options: Callable[[argparse.ArgumentParser], None] | None = None
    takes_log: bool = True


COMMANDS = {
    "summary": LogCommand(
        "what happened, on one page; a line a log for folders", _add_summary, takes_log=False
    ),
    "messages": LogCommand("every type by source: count, rate, first and last"),
    "texts": LogCommand("status texts"),
    "params": LogCommand("parameters and their changes", _add_params),
    "dump": LogCommand("every message as text, JSON or CSV, as mavlogdump prints them", _add_dump),
    "plot": LogCommand("fields over time, on a background of flight modes", _add_plot),
    "report": LogCommand("one HTML page with all of the flight", _add_report),
    "check": LogCommand("health checks, worst first", _add_check),
    "why": LogCommand("the seconds before a gate was missed", _add_why),
    "video": LogCommand("a film: what the camera saw and was decided, and the path", _add_video),
    "export": LogCommand("CSV, Parquet, or MCAP for Foxglove", _add_export),
    "dataset": LogCommand(
        "flights with recorded images as a LeRobot dataset", _add_dataset, takes_log=False
    ),
    "compare": LogCommand("two logs side by side", _add_compare),
    "follow": LogCommand(
        "a log that is being written, or a live link", _add_follow, takes_log=False
    ),
}


@cache
def _help_width() -> int:
    try:
        return int(os.environ.get("COLUMNS", "0")) or os.get_terminal_size(1).columns - 2
    except (ValueError, OSError):  # no number, or no terminal
        return HELP_WIDTH


class _Formatter(argparse.HelpFormatter):
    """Help as wide as the terminal, for which argparse would import shutil and ask per option."""

    def __init__(self, prog: str) -> None:
        super().__init__(prog, width=_help_width())


def build_parser(
    program: str = PROGRAM, names: Iterable[str] = COMMANDS
) -> argparse.ArgumentParser:
    """Return the command line with these commands."""
    parser = OptionParser(prog=program, description=DESCRIPTION, formatter_class=_Formatter)
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True, prog=program)
    for name in names:
        command = COMMANDS[name]
        options = commands.add_parser(
            name, help=command.about, description=command.about, formatter_class=_Formatter
        )
        if command.takes_log:
            options.add_argument("log", metavar="LOG")
        options.add_argument("--json", action="store_true", help="for programs")
        options.add_argument("--system", type=int, metavar="N", help="the vehicle's system id")
        if command.add_options is not None:
            command.add_options(options)
    return parser


def parse(arguments: Sequence[str], program: str = PROGRAM) -> argparse.Namespace:
    """Return the parsed command line; a bare path is a summary of it."""
    given = list(arguments) or ["--help"]
    if given[0] in ("-h", "--help"):
        return build_parser(program).parse_args(given)
    if given[0] not in COMMANDS:
        given.insert(0, "summary")
    return build_parser(program, given[:1]).parse_args(given)


def run(arguments: argparse.Namespace) -> int:
    """Run one command and return its exit code."""
    numpy = single_threaded_numpy()
    module = imported(f"flightstack.logs.commands.{arguments.command}")
    keep_freed_memory(numpy)
    with numpy.errstate(all="ignore"):  # logs hold NaN and worse
        code: int = module.run(arguments)
    return code


def main(arguments: Sequence[str] | None = None, program: str = PROGRAM) -> int:
    """Run the command line; errors are one line, and the exit code says what kind."""
    parsed = parse(sys.argv[1:] if arguments is None else arguments, program)
    try:
        code = run(parsed)
        sys.stdout.flush()
    except BrokenPipeError:  # the reader, such as head, has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except KeyboardInterrupt:
        return 130
    except FlightstackError as error:
        if getattr(parsed, "json", False):
            import json  # noqa: PLC0415  # --help needs none

            print(json.dumps({"error": str(error)}))
        print(f"{program}: {printable(str(error))}", file=sys.stderr)
        return error.exit_code
    return code
