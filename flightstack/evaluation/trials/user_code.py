"""Hash the source of what a user brings: rows of one code must not pass for those of another.

Where the part comes from a package, all *.py below its top-level folder count, in the order of
their paths; where it is a module alone, that file counts. Modules that a lone file imports do not,
nor do data files: what shall be noticed goes into a package. Parts of flightstack itself are left
out, since each row names the commit that flew it. Of a pickled part the file counts.
"""

import hashlib
from collections.abc import Iterator
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path

from flightstack.decision.strategies import STRATEGIES
from flightstack.evaluation.trials.experiment import Competitor, Experiment
from flightstack.extensions import PERCEPTION, PICKLED, PILOT, POLICY, STRATEGY, Group, is_extension

OURS = "flightstack"
BY_OPTION = {f"--{group.kind}": group for group in (PERCEPTION, POLICY, PILOT)}


def code_of(experiment: Experiment) -> dict[str, str]:
    """Return the SHA-256 of every part that users bring's source, by the part's name."""
    groups = {name: group for row in experiment.rows for group, name in _users_parts(row)}
    hashes = {name: _hash_of(group, name) for name, group in sorted(groups.items())}
    return {name: found for name, found in hashes.items() if found is not None}


def _hash_of(group: Group, name: str) -> str | None:
    """Hash the source of one part; None where it is flightstack's own."""
    if name.endswith(PICKLED):
        return hashlib.sha256(Path(name).read_bytes()).hexdigest()
    module = _module(group, name).partition(".")[0]
    return None if module == OURS else _sha256(module)


def _users_parts(row: Competitor) -> Iterator[tuple[Group, str]]:
    for text in row.companion_options:
        option, _, name = text.partition("=")
        if option in BY_OPTION:
            yield BY_OPTION[option], name
    if (
        row.pilot is None
        and row.strategy not in STRATEGIES
        and is_extension(STRATEGY, row.strategy)
    ):
        yield STRATEGY, row.strategy


def _module(group: Group, name: str) -> str:
    module, colon, _ = name.partition(":")
    return module if colon else entry_points(group=group.entry_points)[name].module


def _sha256(module: str) -> str:
    total = hashlib.sha256()
    for name, path in _sources(module):
        total.update(f"{name}\0{hashlib.sha256(path.read_bytes()).hexdigest()}\n".encode())
    return total.hexdigest()


def _sources(module: str) -> list[tuple[str, Path]]:
    """Name the files of a top-level module or package, by their paths below it."""
    spec = find_spec(module)
    if spec is None:
        return []
    if spec.submodule_search_locations is None:
        file = Path(spec.origin or "")
        return [(file.name, file)] if file.is_file() else []
    found = {
        path.relative_to(folder).as_posix(): path
        for folder in spec.submodule_search_locations
        for path in Path(folder).rglob("*.py")
    }
    return sorted(found.items())
