"""Which models are made of which trainings: models.toml, read and checked."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from flightstack.errors import UsageError
from flightstack.perception.config import Sampling
from flightstack.tables import read_toml, record_from_table

FILE = Path(__file__).with_name("models.toml")

EncoderKind = Literal["mcd", "plain"]  # with dropout, or without
PolicyKind = Literal["ensemble", "single", "deterministic"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelPlan:
    """One model: its encoder, the sampling of its posterior, its policies and its strategy."""

    encoder: EncoderKind
    sampling: Sampling
    samples: int
    policy: PolicyKind
    strategy: str


def read_catalogue(path: Path = FILE) -> dict[str, ModelPlan]:
    """Read every model's plan by its name; raises UsageError."""
    try:
        tables = read_toml(path.read_text(), where=path.name)
        return {
            name: record_from_table(ModelPlan, table, where=f"{path.name}: {name}")
            for name, table in tables.items()
        }
    except ValueError as error:
        raise UsageError(str(error)) from error
