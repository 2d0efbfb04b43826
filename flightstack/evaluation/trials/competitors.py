"""Make an experiment's rows from models and strategies, or from parts that a user brings."""

import re
from collections.abc import Sequence
from pathlib import PurePath

from flightstack import models
from flightstack.companion.pilots.choice import BY_ITSELF
from flightstack.companion.pilots.end_to_end import make_end_to_end
from flightstack.companion.pipeline import load_pipeline
from flightstack.errors import UsageError
from flightstack.evaluation.trials.experiment import PILOT_OPTION, Competitor
from flightstack.gate_models import is_gate_model, load_gate_model

PATH_PARTS = 2  # of a model's folder that name it: its recipe and its name
PARTS = ("perception", "policy")


def make_competitors(names: Sequence[str], strategies: Sequence[str]) -> tuple[Competitor, ...]:
    """Pair every model with every strategy; with its own where none is named.

    Raises ModelError or UsageError where one can't fly.
    """
    rows = []
    for model in names:
        own = models.recorded(model).strategy
        for strategy in strategies or (own,):
            _check_loads(model, strategy)
            name = f"{model_name(model)}-{plain_name(strategy)}"
            rows.append(Competitor(name=name, model=model, strategy=strategy))
    return tuple(rows)


def make_users_competitor(
    model: str, strategy: str | None, *, perception: str | None, policy: str | None
) -> Competitor:
    """Make the row of a model with parts that a user brings (docs/bring-your-own.md).

    Raises ModelError or UsageError where it can't fly.
    """
    _check_loads(model, strategy, perception=perception, policy=policy)
    own = models.recorded(model).strategy
    users = dict(zip(PARTS, (perception, policy), strict=True))
    named = [part for part in (perception, policy, strategy) if part is not None]
    return Competitor(
        name="-".join(map(plain_name, named)),
        model=model,
        strategy=strategy or own,
        companion_options=tuple(
            f"--{part}={name}" for part, name in users.items() if name is not None
        ),
    )


def make_pilots_competitor(pilot: str) -> Competitor:
    """Make the row of an end-to-end policy that a user brings, which needs no model.

    Raises UsageError where it does not load.
    """
    try:
        make_end_to_end(pilot)
    except SystemExit as error:
        raise UsageError(f"{pilot} does not load: it ends Python by {error!r}") from error
    return Competitor(
        name=plain_name(pilot),
        model=pilot,
        strategy=BY_ITSELF,
        companion_options=(f"{PILOT_OPTION}{pilot}",),
    )


def _check_loads(
    model: str, strategy: str | None, *, perception: str | None = None, policy: str | None = None
) -> None:
    if is_gate_model(model):
        load_gate_model(model)
        if (perception, policy) != (None, None):
            raise UsageError(f"{model} flies by a belief: it takes no perception and no policy")
        return
    try:
        load_pipeline(model, strategy, perception=perception, policy=policy)
    except SystemExit as error:  # which extensions let through: it is no Exception
        names = ", ".join(name for name in (perception, policy, strategy) if name is not None)
        raise UsageError(f"{names} does not load: it ends Python by {error!r}") from error


def model_name(model: str) -> str:
    """Shorten a model's name or folder to what tells it from others, as "strong.m0"."""
    return ".".join(map(plain_name, PurePath(model).parts[-PATH_PARTS:]))


def plain_name(text: str) -> str:
    """Write a name so that it can be part of a row's, as "mi.mode.lowest" or "my_package.mine"."""
    dotted = re.sub(r"[/:]", ".", text.lower())
    return re.sub(r"[^a-z0-9._+]+", "-", dotted).strip("-._+")
