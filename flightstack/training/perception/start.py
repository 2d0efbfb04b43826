"""What a CM-VAE goes on from: a finished training, or the encoder of a model that flies."""

from dataclasses import dataclass
from pathlib import Path

from torch import Tensor

from flightstack import models
from flightstack.errors import UsageError
from flightstack.networks.cmvae import CmVae
from flightstack.networks.trained import load_trained
from flightstack.perception.labels import LabelScale
from flightstack.training.runs import read_run


@dataclass(frozen=True, slots=True, kw_only=True)
class Start:
    """Weights, by their names in a CM-VAE, and the units of its labels."""

    weights: dict[str, Tensor]
    label_scale: LabelScale
    sha256: str  # of the file that they are from

    @classmethod
    def find(cls, name: str) -> "Start":
        """Read a perception run by its folder, or a model by name or folder.

        A model has no image decoder, which never flies. Raises UsageError or ModelError.
        """
        if (Path(name) / "perception.json").is_file():
            run = read_run(Path(name))
            return cls(weights=run.weights, label_scale=run.label_scale, sha256=run.sha256)
        trained = load_trained(name)
        parts = {"encoder.": trained.encoder, "pose_decoder.": trained.pose_decoder}
        return cls(
            weights={
                prefix + key: value
                for prefix, network in parts.items()
                for key, value in network.state_dict().items()
            },
            label_scale=trained.config.perception.label_scale,
            sha256=models.file_sha256(models.find(name) / models.WEIGHTS_FILE),
        )

    def put_into(self, model: CmVae) -> bool:
        """Give a network these weights; returns whether it can draw images from then on.

        Raises UsageError where their shapes differ.
        """
        own = model.state_dict()
        for key, value in self.weights.items():
            if key not in own or own[key].shape != value.shape:
                raise UsageError(
                    f"--start: {key} does not fit: train with the same latent_dims, and an encoder "
                    "of the same kind"
                )
        model.load_state_dict(self.weights, strict=False)
        return any(key.startswith("image_decoder.") for key in self.weights)
