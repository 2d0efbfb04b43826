"""Find, check and load a trained model: `<recipe>/<name>`, a folder of weights and configuration.

A model's folder holds config.toml (what it is), weights.safetensors (encoder, gate-pose heads and
policies, named by the hash that config.toml records), README.md (its card) and metrics.json.
Folders are looked for where FLIGHTSTACK_MODELS says, else in the repository, else in the package.

A folder is data, whoever made it. It names parts of flightstack and never code, which comes from
the command line alone; and its weights are read once their shapes are known to be what config.toml
says.
"""

import hashlib
import os
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import load_file
from torch import Tensor, nn

from flightstack.decision.strategies import make_strategy
from flightstack.errors import ModelError, UsageError
from flightstack.perception.config import PerceptionConfig
from flightstack.perception.decoders import GatePoseDecoder
from flightstack.perception.dronet import Dronet
from flightstack.perception.labels import LABELS
from flightstack.policy.config import PolicyConfig
from flightstack.policy.network import PolicyStack
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
DTYPES = {torch.float32: "F32", torch.int64: "I64"}  # as safetensors names them
THREADS = 1  # the networks are too small to share among more


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelConfig:
    """What config.toml says."""

    name: str
    recipe: str
    strategy: str  # used where the user names none
    weights_sha256: str
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
    """A model's networks, loaded and ready for inference."""

    config: ModelConfig
    encoder: Dronet
    pose_decoder: GatePoseDecoder
    policies: PolicyStack


def load(name: str) -> Model:
    """Load a model by name ("strong/m0") or by the path of its folder, and warm it up.

    Sets torch to one thread for the whole process. Raises ModelError when the model is unknown,
    damaged, or does not fit its configuration.
    """
    torch.set_num_threads(THREADS)
    folder = find(name)
    config = read_config(folder / CONFIG_FILE)
    weights = _read_weights(folder / WEIGHTS_FILE, config)
    model = build(config)
    for prefix, network in networks(model).items():
        network.load_state_dict(
            {
                key.removeprefix(prefix): value
                for key, value in weights.items()
                if key.startswith(prefix)
            }
        )
    with torch.inference_mode():  # torch's first pass is slow
        mean, _ = model.encoder(torch.zeros(1, 3, 64, 64))
        model.policies(mean)
    return model


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


def build(config: ModelConfig) -> Model:
    """Build the networks that a configuration describes, their weights still at random."""
    perception = config.perception
    encoder = Dronet(latent_dims=perception.latent_dims, dropout=perception.dropout)
    policies = PolicyStack(
        config.policy, latent_dims=perception.latent_dims, generator=torch.Generator()
    )
    return Model(
        config=config,
        encoder=encoder.to(memory_format=torch.channels_last).eval(),  # type: ignore[call-overload]
        pose_decoder=GatePoseDecoder(len(LABELS)).eval(),
        policies=policies.eval(),
    )


def networks(model: Model) -> dict[str, nn.Module]:
    """Name the networks whose weights a model's file holds, by the prefix of their names."""
    return {
        "encoder.": model.encoder,
        "pose_decoder.": model.pose_decoder,
        "policies.": model.policies,
    }


def file_sha256(path: Path) -> str:
    """Hash a file."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _read_weights(path: Path, config: ModelConfig) -> dict[str, Tensor]:
    try:
        if not path.is_file():
            raise ModelError(f"{path} cannot be read: there is no such file")
        if file_sha256(path) != config.weights_sha256:
            raise ModelError(f"{path} is damaged: its hash is not what {CONFIG_FILE} records")
        _check_shapes(path, config)
        return load_file(path)
    except (OSError, SafetensorError) as error:
        raise ModelError(f"{path} cannot be read: {error}") from error


def _check_shapes(path: Path, config: ModelConfig) -> None:
    """Compare a file's table of contents with what a configuration needs; allocates neither."""
    with safe_open(path, "pt") as file:
        slices = {key: file.get_slice(key) for key in file.keys()}  # noqa: SIM118  (no dict)
        found = {key: (each.get_dtype(), tuple(each.get_shape())) for key, each in slices.items()}
    with torch.device("meta"):
        needed = {
            prefix + key: (DTYPES[value.dtype], tuple(value.shape))
            for prefix, network in networks(build(config)).items()
            for key, value in network.state_dict().items()
        }
    for key in sorted(needed.keys() & found.keys()):
        if found[key] != needed[key]:
            (kind, shape), (needed_kind, needed_shape) = found[key], needed[key]
            has = (shape, needed_shape) if shape != needed_shape else (kind, needed_kind)
            raise _misfit(path, f"{key} is {has[0]}, not {has[1]}")
    for key in sorted(needed.keys() - found.keys()):
        raise _misfit(path, f"{key} is missing")
    for key in sorted(found.keys() - needed.keys()):
        raise _misfit(path, f"they hold unknown parts, such as {key!r}")


def _misfit(path: Path, what: str) -> ModelError:
    return ModelError(f"{path.parent}: the weights do not fit {CONFIG_FILE}: {what}")
