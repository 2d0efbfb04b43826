"""`flightstack COMMAND`: find the command, give it its options, from a file too, and run it."""

import argparse
import os
import sys
from collections.abc import Sequence

from flightstack import __version__
from flightstack.arguments.options import leaf
from flightstack.arguments.parser import OptionParser
from flightstack.cli.commands import COMMANDS, PROGRAM, parser_of, program_of

CONFIG, PRINT_CONFIG, HELP = "--config", "--print-config", ("-h", "--help")
END_OF_OPTIONS = "--"
EPILOG = f"""Each COMMAND has a --help of its own, and two options that all have in common:
{CONFIG} FILE reads options from a TOML file, {PRINT_CONFIG} writes such a file.
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command; its exit code is the process's."""
    words = list(sys.argv[1:] if argv is None else argv)
    name = _parse_name(words[:1])
    try:
        code = _run(name, words[1:])
        sys.stdout.flush()
    except BrokenPipeError:  # the reader, such as head, has seen enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except Exception as error:
        if not hasattr(error, "exit_code"):  # the vehicle's errors are no kin of ours
            raise
        print(f"{program_of(name)}: {error}", file=sys.stderr)
        code = int(error.exit_code)
    return code


def build_parser() -> argparse.ArgumentParser:
    """Describe the command line as far as it says which command is meant."""
    parser = OptionParser(
        prog=PROGRAM,
        description="Fly through gates by what a camera sees, and say how sure it is.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--version", action="version", version=f"{PROGRAM} {__version__}")
    commands = parser.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name, command in COMMANDS.items():
        commands.add_parser(name, help=command.about, add_help=False)
    return parser


def add_config_options(parser: argparse.ArgumentParser) -> None:
    """Add what all commands have in common."""
    group = parser.add_argument_group("options from a file")
    group.add_argument(CONFIG, metavar="FILE", help="TOML; the command line goes before it")
    group.add_argument(PRINT_CONFIG, action="store_true", help="write such a file, and do nothing")


def _parse_name(words: Sequence[str]) -> str:
    name: str = build_parser().parse_args(words or HELP[-1:]).command
    return name


def _run(name: str, words: Sequence[str]) -> int:
    own, file, prints = _take_config(words)
    if any(word in HELP for word in own):
        _show_help(name, own)
    if file is not None:
        own = _with_file(name, own, file)
    if prints:
        _print_config(name, own)
        return 0
    code: int = COMMANDS[name].load().main(own, program_of(name))
    return code


def _take_config(words: Sequence[str]) -> tuple[list[str], str | None, bool]:
    """Part our own two options from those of the command."""
    parser = OptionParser(prog=PROGRAM, add_help=False)
    parser.add_argument(CONFIG)
    parser.add_argument(PRINT_CONFIG, action="store_true")
    end = words.index(END_OF_OPTIONS) if END_OF_OPTIONS in words else len(words)
    ours, own = parser.parse_known_args(words[:end])
    return [*own, *words[end:]], ours.config, ours.print_config


def _show_help(name: str, words: Sequence[str]) -> None:
    """Print the command's help with our own two options below it; ends the process."""
    parser = parser_of(name)
    below, _ = leaf(parser, words)
    add_config_options(below)
    below.parse_args(HELP[-1:])


def _with_file(name: str, words: Sequence[str], file: str) -> list[str]:
    from pathlib import Path  # noqa: PLC0415  few need it

    from flightstack.arguments.config_file import words_of  # noqa: PLC0415

    parser, depth = leaf(parser_of(name), words)
    end = words.index(END_OF_OPTIONS) if END_OF_OPTIONS in words else len(words)
    read = words_of(Path(file), parser, words[depth:end])
    return [*words[:end], *read, *words[end:]]


def _print_config(name: str, words: Sequence[str]) -> None:
    from flightstack.arguments.config_file import as_toml  # noqa: PLC0415
    from flightstack.arguments.options import sub_parsers  # noqa: PLC0415
    from flightstack.errors import UsageError  # noqa: PLC0415

    parser, depth = leaf(parser_of(name), words)
    if sub_parsers(parser):
        known = ", ".join(sub_parsers(parser))
        raise UsageError(f"{PRINT_CONFIG}: say which command first: {known}")
    print(as_toml(parser, words[depth:]), end="")
