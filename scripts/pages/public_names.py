"""List the public names that docs/promise.md speaks of.

    python scripts/pages/public_names.py [--write]

Prints those that the code has; --write puts them into docs/public-names.txt, at a release. A test
fails where a name of that file is gone.
"""

import argparse
import inspect
import sys
import types
import typing
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from importlib import import_module
from pathlib import Path
from typing import Any

from flightstack import extensions
from flightstack.arguments.options import sub_parsers
from flightstack.cli.commands import COMMANDS, parser_of
from flightstack.errors import FlightstackError, LinkError, ModelError, UsageError
from flightstack.evaluation.trials.rows import TrialRow
from flightstack.evaluation.trials.rungs import Rung
from flightstack.gate_models import GateModelConfig
from flightstack.models import ModelConfig
from flightstack.training.recipe import Recipe
from sitl import Conditions

DOCUMENT = Path(__file__).resolve().parents[2] / "docs" / "public-names.txt"
ERRORS = (FlightstackError, UsageError, LinkError, ModelError)
MODULES = (  # all of what they give away
    "flightstack",
    "flightstack.errors",
    "flightstack.gym",
    "flightstack.launch",
    "flightstack.logs",
    "flightstack.records",
    "sitl",
)
NAMES = (
    "flightstack.companion.pilots.end_to_end.EndToEndPolicy",
    "flightstack.decision.strategies.Strategy",
    "flightstack.models.Model",
    "flightstack.models.find",
    "flightstack.models.known_models",
    "flightstack.models.load",
    "flightstack.perception.posterior.LatentPosterior",
    "flightstack.policy.ensemble.Policy",
    "flightstack.training.recipe.Recipe",
)
TABLES = {
    "model": ModelConfig,
    "gate-model": GateModelConfig,
    "recipe": Recipe,
    "conditions": Conditions,
    "rung": Rung,
}


def public_names() -> list[str]:
    """Return one line a name, sorted."""
    lines = {
        *_python(),
        *(f"entry-points {each.entry_points} .{each.method}" for each in _groups()),
        *(f"exit-code {kind.__name__} {kind.exit_code}" for kind in ERRORS),
        *(f"csv trials.csv {field.name}" for field in fields(TrialRow)),
        *(f"toml {name} {key}" for name, kind in TABLES.items() for key in _keys(kind)),
        *(line for name in COMMANDS for line in _options(f"flightstack {name}", parser_of(name))),
    }
    return sorted(lines)


def _groups() -> list[extensions.Group]:
    return [value for value in vars(extensions).values() if isinstance(value, extensions.Group)]


def _python() -> Iterator[str]:
    for name in MODULES:
        module = import_module(name)
        own = [
            key
            for key, value in vars(module).items()
            if not key.startswith("_") and getattr(value, "__module__", None) == name
        ]
        for key in getattr(module, "__all__", own):
            yield from _parts(f"{name}.{key}", getattr(module, key))
    for path in NAMES:
        module_name, _, key = path.rpartition(".")
        yield from _parts(path, getattr(import_module(module_name), key))


def _parts(path: str, value: Any) -> Iterator[str]:
    """Name a value, its parameters if it is called, its fields and methods if it is a class."""
    yield f"python {path}"
    if inspect.isfunction(value):
        yield from (f"python {path}({name})" for name in inspect.signature(value).parameters)
    elif inspect.isclass(value):
        if is_dataclass(value):
            yield from (f"python {path}.{field.name}" for field in fields(value))
        methods = inspect.getmembers(value, inspect.isroutine)
        own = [name for name, each in methods if _is_ours(each) and not name.startswith("_")]
        yield from (f"python {path}.{name}()" for name in own)


def _is_ours(method: Any) -> bool:
    return str(getattr(method, "__module__", "")).partition(".")[0] in ("flightstack", "sitl")


def _keys(kind: Any, prefix: str = "") -> Iterator[str]:
    """Name the keys of a table, and those of its tables."""
    hints = typing.get_type_hints(kind)
    for field in fields(kind):
        hint = hints[field.name]
        if isinstance(hint, types.UnionType):
            hint = typing.get_args(hint)[0]
        yield prefix + field.name
        if is_dataclass(hint):
            yield from _keys(hint, f"{prefix}{field.name}.")


def _options(command: str, parser: argparse.ArgumentParser) -> Iterator[str]:
    yield f"command {command}"
    for action in parser._actions:  # noqa: SLF001  argparse has no public name for them
        yield from (f"option {command} {option}" for option in action.option_strings)
    for name, below in sub_parsers(parser).items():
        yield from _options(f"{command} {name}", below)


def main() -> int:
    """Print or write."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", action="store_true")
    text = "\n".join(public_names()) + "\n"
    if parser.parse_args().write:
        DOCUMENT.write_text(text)
    else:
        sys.stdout.write(text)
    return 0


if __name__ == "__main__":
    sys.exit(main())
