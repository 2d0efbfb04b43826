"""Find what a user brings: the name of an installed entry point, or `my_package:MyStrategy`.

Four groups of entry points, each naming a factory that is called with keywords:

    flightstack.perception   factory(model=Model, seed=int)           -> has sample(rgb)
    flightstack.policy       factory(model=Model, seed=int)           -> has predict(z)
    flightstack.strategy     factory(direction="cw"|"ccw", seed=int)  -> has decide(samples)
    flightstack.pilot        factory(direction="cw"|"ccw", seed=int)  -> has act(observation)

A pilot has reset() as well. What these methods take and give stands in the protocols
LatentPosterior, Policy, Strategy and EndToEndPolicy. What has no name to import it by comes in a
file, FILE.pickle: `flightstack.fly` writes such.
"""

import importlib
import pickle
from dataclasses import dataclass
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

from flightstack.errors import UsageError


@dataclass(frozen=True, slots=True, kw_only=True)
class Group:
    """One kind of part that a user can bring."""

    entry_points: str
    kind: str  # in messages
    method: str  # that the part must have
    further: tuple[str, ...] = ()  # methods that it must have, too


PERCEPTION = Group(entry_points="flightstack.perception", kind="perception", method="sample")
POLICY = Group(entry_points="flightstack.policy", kind="policy", method="predict")
STRATEGY = Group(entry_points="flightstack.strategy", kind="strategy", method="decide")
PILOT = Group(entry_points="flightstack.pilot", kind="pilot", method="act", further=("reset",))
PICKLED = ".pickle"  # how the name of a file ends that holds a factory


def installed(group: Group) -> list[str]:
    """Name what installed packages bring."""
    return sorted(entry_points(group=group.entry_points).names)


def is_extension(group: Group, name: str) -> bool:
    """Whether the name is one that `make` would look for outside flightstack."""
    if name.endswith(PICKLED):
        return True
    return ("/" not in name and ":" in name) or name in installed(group)


def make(group: Group, name: str, **arguments: Any) -> Any:
    """Load the factory and call it.

    Raises UsageError, in one line, when it is unknown, cannot be imported or called, or when what
    it makes lacks the group's method.
    """
    try:
        part = _factory(group, name)(**arguments)
    except UsageError:
        raise
    except Exception as error:  # a stranger's code may raise anything; the user needs one line
        reason = (str(error).splitlines() or [""])[0]
        raise UsageError(
            f"{group.kind} {name!r} does not load: {type(error).__name__}: {reason}"
        ) from error
    for method in (group.method, *group.further):
        if not callable(getattr(part, method, None)):
            raise UsageError(
                f"{group.kind} {name!r} does not load: {type(part).__name__} has no method "
                f"{method}(); see docs/bring-your-own.md"
            )
    return part


def _factory(group: Group, name: str) -> Any:
    if name.endswith(PICKLED):
        return pickle.loads(Path(name).read_bytes())  # noqa: S301  code that the user names, as below
    module, colon, attribute = name.partition(":")
    if colon:
        return getattr(importlib.import_module(module), attribute)
    if name not in installed(group):
        known = ", ".join(installed(group)) or "none"
        raise UsageError(
            f"unknown {group.kind} {name!r}: installed are {known}; "
            "or name one as my_package:MyPart"
        )
    return entry_points(group=group.entry_points)[name].load()
