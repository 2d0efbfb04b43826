"""Look at the options of any argparse parser: which there are, and which a command line gives.

argparse has no public names for what a parser holds; they are used here and nowhere else.
"""

# ruff: noqa: SLF001  (see above)

import argparse
from collections.abc import Iterator, Mapping, Sequence

Option = argparse.Action


def options_of(parser: argparse.ArgumentParser) -> dict[str, Option]:
    """Return the options that have a long name, by that name without its dashes; --help is none."""
    return {
        long_name(action)[2:]: action
        for action in parser._actions
        if any(s.startswith("--") for s in action.option_strings) and "--help" not in names(action)
    }


def ask_for_nothing(parser: argparse.ArgumentParser) -> None:
    """Let the parser take a command line that lacks what it needs, by name or by position."""
    for action in parser._actions:
        action.required = False
        if not action.option_strings:
            action.nargs, action.choices = "*", None


def is_switch(option: Option) -> bool:
    """Whether it takes no value."""
    return option.nargs == 0


def is_counted(option: Option) -> bool:
    """Whether it is a switch that says more the more often it is given."""
    return isinstance(option, argparse._CountAction)


def is_repeated(option: Option) -> bool:
    """Whether it may be given several times, with a value each."""
    return isinstance(option, argparse._AppendAction)


def takes_several(option: Option) -> bool:
    """Whether it takes several values at once."""
    return option.nargs in ("*", "+")


def long_name(option: Option) -> str:
    """Return its first long name, dashes and all."""
    return next(name for name in option.option_strings if name.startswith("--"))


def names(option: Option) -> Sequence[str]:
    """Return all spellings of an option."""
    return option.option_strings


def rivals_of(parser: argparse.ArgumentParser, option: Option) -> list[Option]:
    """Return the options of which only one may be given, this one among them."""
    for group in parser._mutually_exclusive_groups:
        if option in group._group_actions:
            return list(group._group_actions)
    return [option]


def sub_parsers(parser: argparse.ArgumentParser) -> Mapping[str, argparse.ArgumentParser]:
    """Return the parsers of a command's sub-commands, by name."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            return dict(action.choices)
    return {}


def all_of(parser: argparse.ArgumentParser) -> Iterator[Option]:
    """Yield whatever a command and its sub-commands take, by name or by position."""
    yield from parser._actions
    for below in sub_parsers(parser).values():
        yield from all_of(below)


def leaf(
    parser: argparse.ArgumentParser, words: Sequence[str]
) -> tuple[argparse.ArgumentParser, int]:
    """Return the parser of the sub-command that the first words name, and how many they are."""
    depth = 0
    for word in words:
        below = sub_parsers(parser)
        if word not in below:
            break
        parser, depth = below[word], depth + 1
    return parser, depth


def is_given(option: Option, words: Sequence[str]) -> bool:
    """Whether a command line holds the option, in any of its spellings."""
    return any(_spells(name, word) for name in names(option) for word in words)


def _spells(name: str, word: str) -> bool:
    if name.startswith("--"):
        return word == name or word.startswith(f"{name}=")
    return word.startswith(name) and not word.startswith("--")  # -o FILE, -oFILE, -vv
