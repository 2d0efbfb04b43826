"""The command line: python -m flightstack.logs LOG."""

import argparse
import importlib
import json
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from flightstack.errors import FlightstackError

COMMANDS = (
    "summary",
    "messages",
    "texts",
    "params",
    "dump",
    "plot",
    "report",
    "check",
    "why",
    "export",
    "compare",
    "follow",
)
DESCRIPTION = "Inspect MAVLink logs (tlogs). A bare path gives the summary."


def _add_summary(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("paths", nargs="+", type=Path, metavar="PATH", help="logs, or folders")
    parser.add_argument("--checks", type=Path, metavar="FILE", help="your own checks, in Python")


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
    add("-o", "--output", type=Path, metavar="TLOG", help="write matching records to a tlog")
    add("-q", "--quiet", action="store_true", help="print nothing")
    add("--robust", action="store_true", help="accepted for mavlogdump's sake: always so")
    add("--no-bad-data", action="store_true", help="accepted for mavlogdump's sake: always so")


def _add_plot(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("fields", nargs="+", metavar="FIELD", help='such as ATTITUDE.roll or "degrees(VFR_HUD.x)"')
    add("-o", "--output", type=Path, metavar="FILE", help="PNG or SVG; default beside the log")
    add("--from", dest="start", type=float, metavar="S", help="seconds since the log's start")
    add("--to", dest="end", type=float, metavar="S", help="seconds since the log's start")


def _add_report(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("-o", "--output", type=Path, metavar="HTML", help="default beside the log")
    add("--frames", type=Path, metavar="FOLDER", help="recorded frames; default LOG.frames")
    add("--checks", type=Path, metavar="FILE", help="your own checks, in Python")


def _add_check(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--checks", type=Path, metavar="FILE", help="your own checks, in Python")
    parser.add_argument("--strict", action="store_true", help="exit 1 if a check finds an error")


def _add_why(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("--seconds", type=float, default=2.0, metavar="S", help="how far to look back")
    add("--frames", type=Path, metavar="FOLDER", help="recorded frames; default LOG.frames")
    add("-o", "--output", type=Path, metavar="PNG", help="draw the strip")


def _add_export(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("--format", choices=("csv", "parquet", "mcap"), help="default: by the output's ending")
    add("-o", "--output", type=Path, metavar="PATH", help="file (MCAP) or folder (CSV, Parquet)")
    add("--types", metavar="A,B", help="message types, comma separated, with wildcards")


def _add_follow(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("source", metavar="LOG|LINK", help="a log being written, or udpin:0.0.0.0:14550, tcp:...")
    add("--types", metavar="A,B", help="print these messages too; default: events and rates")
    add("--seconds", type=float, default=0.0, metavar="S", help="stop after so long; 0: never")
    add("--from-start", action="store_true", help="begin at the start of the log, not its end")


def build_parser() -> argparse.ArgumentParser:
    """Return the whole command line."""
    parser = argparse.ArgumentParser(prog="python -m flightstack.logs", description=DESCRIPTION)
    commands = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)

    def add(name: str, about: str, *, log: bool = True) -> argparse.ArgumentParser:
        command = commands.add_parser(name, help=about, description=about)
        if log:
            command.add_argument("log", type=Path, metavar="LOG")
        command.add_argument("--json", action="store_true", help="for programs")
        command.add_argument("--system", type=int, metavar="N", help="the vehicle's system id")
        return command

    _add_summary(add("summary", "what happened, on one page; a line a log for folders", log=False))
    add("messages", "every type by source: count, rate, first and last")
    add("texts", "status texts")
    _add_params(add("params", "parameters and their changes"))
    _add_dump(add("dump", "every message as text, JSON or CSV, as mavlogdump prints them"))
    _add_plot(add("plot", "fields over time, on a background of flight modes"))
    _add_report(add("report", "one HTML page with all of the flight"))
    _add_check(add("check", "health checks, worst first"))
    _add_why(add("why", "the seconds before a gate was missed"))
    _add_export(add("export", "CSV, Parquet, or MCAP for Foxglove"))
    add("compare", "two logs side by side").add_argument("other", type=Path, metavar="OTHER")
    _add_follow(add("follow", "a log that is being written, or a live link", log=False))
    return parser


def _with_command(arguments: Sequence[str]) -> list[str]:
    """Return the arguments with "summary" before a bare path."""
    given = list(arguments)
    options = ("-h", "--help")
    if given and given[0] not in (*COMMANDS, *options):
        return ["summary", *given]
    return given or ["--help"]


def run(arguments: argparse.Namespace) -> int:
    """Run one command and return its exit code."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # numpy then starts in half the time
    module = importlib.import_module(f"flightstack.logs.commands.{arguments.command}")
    numpy = importlib.import_module("numpy")
    with numpy.errstate(all="ignore"):  # logs hold NaN and worse
        code: int = module.run(arguments)
    return code


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; errors are one line, and the exit code says what kind."""
    parsed = build_parser().parse_args(
        _with_command(sys.argv[1:] if arguments is None else arguments)
    )
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
            print(json.dumps({"error": str(error)}))
        print(f"error: {error}", file=sys.stderr)
        return error.exit_code
    return code
