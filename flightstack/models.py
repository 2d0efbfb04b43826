"""Find, check and load a trained model: `<recipe>/<name>`, a folder of networks and configuration.

A model's folder holds config.toml (what it is), encoder.onnx and policies.onnx (its flight form,
named by the hashes that config.toml records), weights.safetensors (what training goes on from, and
the flight form is exported from: see networks/trained.py), README.md (its card) and metrics.json.
Folders are looked for where FLIGHTSTACK_MODELS says, else in the repository, else in the package.

A folder is data, whoever made it. It names parts of flightstack and never code, which comes from
the command line alone.
"""

import hashlib
import os
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from flightstack.decision.strategies import make_strategy
from flightstack.errors import ModelError, UsageError
from flightstack.perception.config import PerceptionConfig
from flightstack.perception.encoder import Encoder
from flightstack.policy.config import PolicyConfig
from flightstack.policy.networks import PolicyNetworks
from flightstack.tables import read_toml, record_from_table

DEFAULT_MODEL = "strong/m0"
CONFIG_FILE, WEIGHTS_FILE = "config.toml", "weights.safetensors"
FOLDERS_VARIABLE = "FLIGHTSTACK_MODELS"
PACKAGE = Path(__file__).parent
PUBLISHED = (PACKAGE.parent / "models", PACKAGE / "_models")  # what comes with flightstack
MAX_CONFIG_BYTES = 1 << 20
MAX_SPEED_M_S = 10.0
MAX_SIZE = 1 << 16  # of any one dimension: a product of three still fits a tensor's own count
MAX_ACTIONS = 1 << 20  # N x M x mixture


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightForm:
    """The hashes of a model's graphs; empty where they have not been exported."""

    encoder_sha256: str = ""
    policies_sha256: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelConfig:
    """What config.toml says."""

    name: str
    recipe: str
    strategy: str  # used where the user names none
    weights_sha256: str
    flight: FlightForm = FlightForm()
    perception: PerceptionConfig
    policy: PolicyConfig

    def __post_init__(self) -> None:
        """Refuse sizes that nobody means, and parts that are not flightstack's own."""
        perception, policy = self.perception, self.policy
        sizes = (perception.latent_dims, policy.members, policy.mixture, *policy.hidden)
        if max(sizes) > MAX_SIZE:
            raise ValueError(f"a size of {max(sizes)}: {MAX_SIZE} is the largest")
        actions = policy.members * perception.samples * policy.mixture
        if actions > MAX_ACTIONS:
            raise ValueError(f"{actions} actions an image: {MAX_ACTIONS} is the most")
        try:
            make_strategy(self.strategy, best_member=policy.best_member or (0, 0, 0, 0))
        except UsageError as error:
            raise ValueError(
                f"strategy {self.strategy!r} is not flightstack's own: a model is data; "
                "name code of yours by --strategy"
            ) from error


class Recorded(NamedTuple):
    """What configurations of all kinds of models say."""

    strategy: str  # used where the user names none
    weights_sha256: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Model:
    """A model's networks in their flight form, loaded."""

    config: ModelConfig
    encoder: Encoder
    policies: PolicyNetworks


def load(name: str) -> Model:
    """Load a model by name ("strong/m0") or by the path of its folder.

    Raises ModelError when the model is unknown, damaged, or does not fit its configuration.
    """
    folder = find(name)
    config = read_config(folder / CONFIG_FILE)
    if not (config.flight.encoder_sha256 and config.flight.policies_sha256):
        raise unexported(name)
    return Model(
        config=config,
        encoder=Encoder(folder, config.perception, sha256=config.flight.encoder_sha256),
        policies=PolicyNetworks(
            folder,
            config.policy,
            latent_dims=config.perception.latent_dims,
            sha256=config.flight.policies_sha256,
        ),
    )


def unexported(name: str) -> ModelError:
    """Say of a model that it has weights alone."""
    return ModelError(
        f"{name} has no flight form yet: 'python -m flightstack.training export {name}' makes it"
    )


def find(name: str) -> Path:
    """Find a model's folder."""
    if (Path(name) / CONFIG_FILE).is_file():
        return Path(name)
    for folder in folders():
        if (folder / name / CONFIG_FILE).is_file():
            return folder / name
    known = ", ".join(known_models()) or "none; train some with 'python -m flightstack.training'"
    raise ModelError(f"unknown model {name!r}: known are {known}")


def known_models() -> list[str]:
    """Name every model that can be found."""
    found = {
        config.parent.relative_to(folder).as_posix()
        for folder in folders()
        for config in folder.glob(f"*/*/{CONFIG_FILE}")
    }
    return sorted(found)


def folders() -> list[Path]:
    """Where models are looked for, first to last."""
    named = os.environ.get(FOLDERS_VARIABLE)
    return [Path(named)] if named else list(PUBLISHED)


def read_config(path: Path) -> ModelConfig:
    """Read and check a config.toml; raises ModelError."""
    try:
        with path.open("rb") as file:
            text = file.read(MAX_CONFIG_BYTES).decode()
        table = read_toml(text, where=str(path))
        return record_from_table(ModelConfig, table, where=str(path))
    except (OSError, ValueError) as error:
        raise ModelError(f"{error}" if str(path) in str(error) else f"{path}: {error}") from error


def recorded(name: str) -> Recorded:
    """Return what any model's configuration records, of whatever kind it is; or ModelError."""
    path = find(name) / CONFIG_FILE
    try:
        with path.open("rb") as file:
            table = read_toml(file.read(MAX_CONFIG_BYTES).decode(), where=str(path))
        return Recorded(str(table["strategy"]), str(table["weights_sha256"]))
    except (OSError, ValueError) as error:
        raise ModelError(f"{path}: {error}") from error
    except KeyError as error:
        raise ModelError(f"{path}: {error} is missing") from error


def file_sha256(path: Path) -> str:
    """Hash a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
