"""The options of a command from a TOML file, and written as one.

A key is an option's long name without its dashes. A switch takes true or false, an option that may
be given several times an array or a number of times; everything else is read as if it stood on the
command line. What does stand there goes before the file.
"""

import argparse
import json
import tomllib
from collections.abc import Sequence
from pathlib import Path

from flightstack.arguments.options import (
    Option,
    ask_for_nothing,
    is_counted,
    is_given,
    is_repeated,
    is_switch,
    long_name,
    options_of,
    rivals_of,
    takes_several,
)
from flightstack.errors import UsageError
from flightstack.tables import read_toml

ANY = "*"  # nargs: none, too


def words_of(path: Path, parser: argparse.ArgumentParser, words: Sequence[str]) -> list[str]:
    """Return what a file says, as words of a command line that lacks it.

    Raises UsageError, in one line, where the file cannot be read, or a key or value cannot be.
    """
    try:
        table = read_toml(path.read_text(), where=str(path))
    except OSError as error:
        raise UsageError(f"--config {path}: {error.strerror}") from None
    except UnicodeDecodeError:
        raise UsageError(f"--config {path}: is no text in UTF-8") from None
    except ValueError as error:
        raise UsageError(str(error)) from None
    known = options_of(parser)
    found: list[str] = []
    for key, value in table.items():
        if key not in known:
            raise UsageError(f"{path}: unknown key {key!r}; known are {', '.join(known)}")
        option = known[key]
        if not any(is_given(rival, words) for rival in rivals_of(parser, option)):
            found += _words(option, value, where=f"{path}: {key}")
    return found


def _words(option: Option, value: object, *, where: str) -> list[str]:
    """Return one option as it would stand on the command line."""
    name = long_name(option)
    if is_counted(option) and type(value) is int:
        return [name] * value
    if is_switch(option):
        if not isinstance(value, bool):
            raise UsageError(f"{where}: expected true or false, got {value!r}")
        return [name] if value else []
    if not (is_repeated(option) or takes_several(option)):
        return [f"{name}={_text(value, where)}"]
    if not isinstance(value, list):
        raise UsageError(f"{where}: expected an array, got {value!r}")
    texts = [_text(one, where) for one in value]
    if is_repeated(option):
        return [f"{name}={text}" for text in texts]
    return [name, *texts] if texts or option.nargs == ANY else []


def _text(value: object, where: str) -> str:
    if isinstance(value, bool) or not isinstance(value, str | int | float):
        raise UsageError(f"{where}: expected a text or a number, got {value!r}")
    return str(value)


def as_toml(parser: argparse.ArgumentParser, words: Sequence[str]) -> str:
    """Write every option of a command with its value, so that the file gives the same again.

    `words` are the command line without what is given by position, which may be missing. The
    parser is used up: it takes any text from now on. Raises what its own errors raise.
    """
    options = options_of(parser)
    ask_for_nothing(parser)
    parser.parse_args(words)  # for its errors
    texts = {key for key, option in options.items() if option.type is None}
    for option in options.values():
        option.type = option.choices = None  # from here on: what was written, not what it means
    values = vars(parser.parse_args(words))
    return "".join(
        _line(key, _literal(values[option.dest], quoted=key in texts), option, parser.prog)
        for key, option in options.items()
    )


def _line(key: str, literal: str | None, option: Option, program: str) -> str:
    about = (option.help or "") % {**vars(option), "prog": program}
    comment = f"  # {about}" if about else ""
    return f"# {key} ={comment}\n" if literal is None else f"{key} = {literal}{comment}\n"


def _literal(value: object, *, quoted: bool) -> str | None:
    """Write a value as TOML; texts that read as numbers are written as such, unless `quoted`."""
    if value is None:
        return None
    if isinstance(value, list):
        return f"[{', '.join(str(_literal(one, quoted=quoted)) for one in value)}]"
    if isinstance(value, tuple):  # a default that was never a text: as it would be written
        value = ",".join(map(str, value))
    if isinstance(value, bool | int | float):
        return json.dumps(value)
    text = str(value)
    return text if not quoted and _is_number(text) else json.dumps(text, ensure_ascii=False)


def _is_number(text: str) -> bool:
    """Whether TOML reads the text as a number that is written the same again."""
    try:
        number = tomllib.loads(f"x = {text}")["x"]
    except tomllib.TOMLDecodeError:
        return False
    return type(number) in (int, float) and str(number) == text
