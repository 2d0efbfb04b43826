"""A model's networks as they were trained: built from its configuration, read from its weights.

weights.safetensors holds encoder, gate-pose heads and policies, and is known by the hash that
config.toml records; it is read once its shapes are known to be what config.toml says.
"""

from dataclasses import dataclass
from pathlib import Path

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import load_file
from torch import Tensor, nn

from flightstack import models
from flightstack.errors import ModelError
from flightstack.models import CONFIG_FILE, WEIGHTS_FILE, ModelConfig, file_sha256
from flightstack.networks.decoders import GatePoseDecoder
from flightstack.networks.dronet import Dronet
from flightstack.networks.gate_network import GateNetwork
from flightstack.networks.policy_stack import PolicyStack
from flightstack.perception.labels import LABELS

DTYPES = {torch.float32: "F32", torch.int64: "I64"}  # as safetensors names them


@dataclass(frozen=True, slots=True, kw_only=True)
class TrainedModel:
    """A model's networks, in eval mode."""

    config: ModelConfig
    encoder: Dronet
    pose_decoder: GatePoseDecoder
    policies: PolicyStack


def load_trained(name: str) -> TrainedModel:
    """Load a model by name ("strong/m0") or by the path of its folder.

    Raises ModelError when the model is unknown, damaged, or does not fit its configuration.
    """
    folder = models.find(name)
    config = models.read_config(folder / CONFIG_FILE)
    weights = _read_weights(folder / WEIGHTS_FILE, config.weights_sha256, _needed(config))
    model = build(config)
    for prefix, network in networks(model).items():
        own = {
            key.removeprefix(prefix): value
            for key, value in weights.items()
            if key.startswith(prefix)
        }
        network.load_state_dict(own)
    return model


def load_gate_network(folder: Path, *, sha256: str) -> GateNetwork:
    """Load a detector's network from a model's folder; raises ModelError."""
    network = GateNetwork()
    needed = {key: _kind(value) for key, value in network.state_dict().items()}
    network.load_state_dict(_read_weights(folder / WEIGHTS_FILE, sha256, needed))
    return network.eval()


def build(config: ModelConfig) -> TrainedModel:
    """Build the networks that a configuration describes, their weights still at random."""
    perception = config.perception
    encoder = Dronet(latent_dims=perception.latent_dims, dropout=perception.dropout)
    policies = PolicyStack(
        config.policy, latent_dims=perception.latent_dims, generator=torch.Generator()
    )
    return TrainedModel(
        config=config,
        encoder=encoder.to(memory_format=torch.channels_last).eval(),  # type: ignore[call-overload]
        pose_decoder=GatePoseDecoder(len(LABELS)).eval(),
        policies=policies.eval(),
    )


def networks(model: TrainedModel) -> dict[str, nn.Module]:
    """Name the networks whose weights a model's file holds, by the prefix of their names."""
    return {
        "encoder.": model.encoder,
        "pose_decoder.": model.pose_decoder,
        "policies.": model.policies,
    }


Kind = tuple[str, tuple[int, ...]]  # of number, and the shape


def _needed(config: ModelConfig) -> dict[str, Kind]:
    """Return what a configuration needs; allocates nothing."""
    with torch.device("meta"):
        return {
            prefix + key: _kind(value)
            for prefix, network in networks(build(config)).items()
            for key, value in network.state_dict().items()
        }


def _kind(value: Tensor) -> Kind:
    return DTYPES[value.dtype], tuple(value.shape)


def _read_weights(path: Path, sha256: str, needed: dict[str, Kind]) -> dict[str, Tensor]:
    try:
        if not path.is_file():
            raise ModelError(f"{path} cannot be read: there is no such file")
        if file_sha256(path) != sha256:
            raise ModelError(f"{path} is damaged: its hash is not what {CONFIG_FILE} records")
        _check_shapes(path, needed)
        return load_file(path)
    except (OSError, SafetensorError) as error:
        raise ModelError(f"{path} cannot be read: {error}") from error


def _check_shapes(path: Path, needed: dict[str, Kind]) -> None:
    """Compare a file's table of contents with what is needed."""
    with safe_open(path, "pt") as file:
        slices = {key: file.get_slice(key) for key in file.keys()}  # noqa: SIM118  (no dict)
        found = {key: (each.get_dtype(), tuple(each.get_shape())) for key, each in slices.items()}
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
