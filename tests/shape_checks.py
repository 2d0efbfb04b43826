"""Check the types and shapes in flightstack's signatures whenever a test calls a function."""

from typing import Any, Self

from beartype import BeartypeConf, FrozenDict, beartype
from jaxtyping import install_import_hook

ROOMS = (
    "records",
    "inference",
    "perception",
    "policy",
    "decision",
    "networks",
    "training",
    "models",
    "extensions",
)

checked = beartype(
    conf=BeartypeConf(
        is_pep484_tower=True,  # a whole number passes for a float, as for mypy
        hint_overrides=FrozenDict({Self: Any}),  # which only decorated classes know
    )
)


def install() -> None:
    """Have every module of the rooms checked that is imported from now on."""
    install_import_hook([f"flightstack.{room}" for room in ROOMS], f"{__name__}.checked")
