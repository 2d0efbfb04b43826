"""Where trainings leave their results: written and read again."""

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal, get_args

from safetensors import SafetensorError
from safetensors.torch import load_file, save_file
from torch import Tensor, nn

from flightstack.errors import UsageError
from flightstack.files import write_whole
from flightstack.models import file_sha256
from flightstack.networks.dronet import Dronet
from flightstack.perception.labels import LabelScale

Report = Callable[[str], None]
Kind = Literal["perception", "policy"]


@dataclass(frozen=True, slots=True, kw_only=True)
class FinishedRun:
    """A finished training: its weights, their hash, and everything that led to them."""

    folder: Path
    weights: dict[str, Tensor]
    sha256: str
    summary: dict[str, Any]  # settings, data hash, metrics

    @property
    def label_scale(self) -> LabelScale:
        """The label scale of a perception run."""
        table = self.summary["label_scale"]
        return LabelScale(offset=tuple(table["offset"]), scale=tuple(table["scale"]))

    def encoder(self) -> Dronet:
        """Rebuild the encoder of a perception run."""
        encoder = Dronet(latent_dims=self.summary["latent_dims"], dropout=self.summary["dropout"])
        prefix = "encoder."
        encoder.load_state_dict(
            {k.removeprefix(prefix): v for k, v in self.weights.items() if k.startswith(prefix)}
        )
        return encoder.eval()


def perception_folder(runs: Path, encoder: str, seed: int) -> Path:
    """Name the run of one encoder, "mcd" or "plain"."""
    return runs / f"perception-{encoder}-{seed}"


def policy_folder(runs: Path, encoder: str, policy: str, seed: int) -> Path:
    """Name the run of one stack of policies on one encoder."""
    return runs / f"policy-{encoder}-{policy}-{seed}"


def write_run(folder: Path, kind: Kind, network: nn.Module, summary: dict[str, Any]) -> None:
    """Leave a finished training's weights, and last what led to them."""
    weights = {key: value.contiguous().cpu() for key, value in network.state_dict().items()}
    save_file(weights, folder / f"{kind}.safetensors")
    write_whole(folder / f"{kind}.json", json.dumps(summary, indent=2) + "\n")


def read_run(folder: Path) -> FinishedRun:
    """Open a finished run of either kind.

    Raises UsageError when the folder holds none.
    """
    for kind in get_args(Kind):
        summary, weights = folder / f"{kind}.json", folder / f"{kind}.safetensors"
        if summary.is_file() and weights.is_file():
            return _read(folder, summary, weights)
    raise UsageError(f"{folder}: no finished training here; run it again to finish it")


def _read(folder: Path, summary: Path, weights: Path) -> FinishedRun:
    try:
        return FinishedRun(
            folder=folder,
            weights=load_file(weights),
            sha256=file_sha256(weights),
            summary=json.loads(summary.read_text()),
        )
    except (OSError, ValueError, SafetensorError) as error:
        raise UsageError(f"{folder}: damaged ({error}); remove it and train again") from error
