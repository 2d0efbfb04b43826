"""Find, check and load a trained model: `<recipe>/<name>`, a folder of weights and configuration.

A model's folder holds config.toml (what it is), weights.safetensors (encoder, gate-pose heads and
policies, named by the hash that config.toml records), README.md (its card) and metrics.json.
Folders are looked for where FLIGHTSTACK_MODELS says, else in the repository, else in the package.
"""

import hashlib
import os
from dataclasses import dataclass
from pathlib import Path

import torch
from safetensors import SafetensorError
from safetensors.torch import load_file
from torch import Tensor, nn

from flightstack.errors import ModelError
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
    model = build(config)
    weights = _read_weights(folder / WEIGHTS_FILE, config.weights_sha256)
    for prefix, network in networks(model).items():
        _fill(network, prefix, weights, folder)
    if weights:
        raise ModelError(f"{folder}: the weights hold unknown parts, such as {min(weights)!r}")
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
    return [Path(named)] if named else [PACKAGE.parent / "models", PACKAGE / "_models"]


def read_config(path: Path) -> ModelConfig:
    """Read and check a config.toml; raises ModelError."""
    try:
        table = read_toml(path.read_text(), where=str(path))
        return record_from_table(ModelConfig, table, where=str(path))
    except (OSError, ValueError) as error:
        raise ModelError(f"{error}" if str(path) in str(error) else f"{path}: {error}") from error


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


def _read_weights(path: Path, sha256: str) -> dict[str, Tensor]:
    try:
        if file_sha256(path) != sha256:
            raise ModelError(f"{path} is damaged: its hash is not what {CONFIG_FILE} records")
        return load_file(path)
    except (OSError, SafetensorError) as error:
        raise ModelError(f"{path} cannot be read: {error}") from error


def _fill(network: nn.Module, prefix: str, weights: dict[str, Tensor], folder: Path) -> None:
    """Move the weights under `prefix` into a network; raises ModelError where they do not fit."""
    own = {key: weights.pop(key) for key in list(weights) if key.startswith(prefix)}
    expected = {prefix + key: value.shape for key, value in network.state_dict().items()}
    for key in sorted(expected.keys() | own.keys()):
        shape = tuple(own[key].shape) if key in own else "nothing"
        wanted = tuple(expected[key]) if key in expected else "nothing"
        if shape != wanted:
            raise ModelError(
                f"{folder}: the weights do not fit {CONFIG_FILE}: {key} is {shape}, not {wanted}"
            )
    network.load_state_dict({key.removeprefix(prefix): value for key, value in own.items()})
