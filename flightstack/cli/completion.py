"""Write what a shell needs to complete the words of `flightstack` and of all its commands.

flightstack completion bash > ~/.local/share/bash-completion/completions/flightstack
"""

import argparse
from collections.abc import Sequence

from flightstack.arguments.options import all_of
from flightstack.arguments.parser import OptionParser
from flightstack.cli.commands import COMMANDS, PROGRAM, parser_of
from flightstack.cli.main import add_config_options

SHELLS = ("bash", "zsh")  # shtab's tcsh knows no options of sub-commands

FILES = ("FILE", "PATH", "LOG", "OTHER", "HTML", "PNG", "TLOG", "LOG|LINK")
FOLDERS = ("DIR", "FOLDER")
KINDS = dict.fromkeys(FILES, "FILE") | dict.fromkeys(FOLDERS, "DIRECTORY")  # by metavar


def build_parser(program: str) -> argparse.ArgumentParser:
    """Describe the command line."""
    parser = OptionParser(
        prog=program, description="Write what a shell needs to complete the words of this command."
    )
    parser.add_argument("shell", choices=SHELLS, metavar="SHELL", help=", ".join(SHELLS))
    return parser


def main(arguments: Sequence[str], program: str) -> int:
    """Print the script."""
    from flightstack.libraries import load_library  # noqa: PLC0415

    shell = build_parser(program).parse_args(arguments).shell
    shtab = load_library("shtab", "completion")
    parser = whole_parser()
    for option in all_of(parser):
        kind = KINDS.get(str(option.metavar))
        if kind is not None:
            option.complete = getattr(shtab, kind)  # type: ignore[attr-defined]
    print(shtab.complete(parser, shell))
    return 0


def whole_parser() -> argparse.ArgumentParser:
    """Return the parser of all commands with all their options."""
    parser = OptionParser(prog=PROGRAM)
    parser.add_argument("--version", action="store_true", help="say which version this is")
    commands = parser.add_subparsers(dest="command", parser_class=_parser_of)  # type: ignore[call-overload]
    for name, command in COMMANDS.items():
        add_config_options(commands.add_parser(name, help=command.about))
    return parser


def _parser_of(*, prog: str, **_: object) -> argparse.ArgumentParser:
    """Be what argparse calls for the parser of a sub-command."""
    return parser_of(prog.removeprefix(f"{PROGRAM} "))
