"""Judge a CM-VAE: label errors against a constant's, and the life of every latent dimension."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
import torch
from jaxtyping import Float32, Int64
from numpy.typing import NDArray

from flightstack.arrays import Labels
from flightstack.networks.cmvae import CmVae, kl_to_standard_normal
from flightstack.perception.labels import LABELS, RANGE, LabelScale
from flightstack.training.batches import ImageSource
from flightstack.training.errors import TrainingError

ACTIVE_VARIANCE = 0.01  # Burda et al. 2016: a unit is active where Var_x(mu) exceeds it
MIN_ACTIVE_UNITS = 5
MAX_ERROR_RATIO = 0.9  # of the constant predictor's error; above it the label was not learned
BAND_M = (1.5, 8.0)
BATCH = 256


@dataclass(frozen=True, slots=True, kw_only=True)
class PerceptionMetrics:
    """Figures over validation images, dropout off, latent at its mean."""

    images: int
    image_mse: float  # of a pixel in [-1, 1]
    label_mae: tuple[float, ...]  # (4,) m, rad, rad, rad
    constant_mae: tuple[float, ...]  # (4,) of the training labels' median
    band_mae: tuple[float, ...]  # (4,) over the gates within BAND_M, where a passage is decided
    kl: tuple[float, ...]  # (Z,) nats
    activity: tuple[float, ...]  # (Z,) variance of the latent mean over the images

    @property
    def active_units(self) -> int:
        """How many latent dimensions say anything about the image."""
        return sum(value > ACTIVE_VARIANCE for value in self.activity)

    @property
    def error_ratios(self) -> tuple[float, ...]:
        """Each label's error as a share of the constant predictor's."""
        pairs = zip(self.label_mae, self.constant_mae, strict=True)
        return tuple(error / max(constant, 1e-12) for error, constant in pairs)

    def curves(self) -> dict[str, float]:
        """Name what is followed over the epochs: errors in m and rad, and the posterior's life."""
        return {
            "image_mse": self.image_mse,
            **dict(zip(LABELS, self.label_mae, strict=True)),
            "kl": sum(self.kl),
            "active_units": self.active_units,
        }

    def line(self) -> str:
        """Say it in one line of progress."""
        names = (name.rsplit("_", 1)[0] for name in LABELS)
        ratios = zip(names, self.error_ratios, strict=True)
        labels = " ".join(f"{name} {ratio:.2f}" for name, ratio in ratios)
        return (
            f"image {self.image_mse:.4f}, error/constant: {labels}, "
            f"KL {sum(self.kl):.1f} nats, {self.active_units} active"
        )

    def table(self) -> str:
        """Say it at length, angles in degrees."""
        lines = [f"validation images: {self.images}, image MSE {self.image_mse:.4f}"]
        for k, name in enumerate(LABELS):
            unit, factor = ("m", 1.0) if name.endswith("_m") else ("deg", np.degrees(1.0))
            error, constant = self.label_mae[k] * factor, self.constant_mae[k] * factor
            band = f"{self.band_mae[k] * factor:.2f} {unit} from {BAND_M[0]} to {BAND_M[1]} m"
            lines.append(
                f"{name:>14}: error {error:.2f} {unit} ({band}), constant {constant:.2f} {unit}"
            )
        for k, (kl, activity) in enumerate(zip(self.kl, self.activity, strict=True)):
            lines.append(f"{f'z{k}':>14}: KL {kl:5.2f} nats, activity {activity:.3f}")
        return "\n".join(lines)

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return {
            **asdict(self),
            "active_units": self.active_units,
            "labels": list(LABELS),
            "band_m": list(BAND_M),
        }

    def require_healthy(self) -> None:
        """Raise TrainingError when a label or the posterior collapsed."""
        for name, ratio in zip(LABELS, self.error_ratios, strict=True):
            if not ratio < MAX_ERROR_RATIO:
                raise TrainingError(
                    f"label {name} was not learned: its error is {ratio:.2f} of a constant's; "
                    "give it a higher weight, more epochs or another seed"
                )
        if self.active_units < MIN_ACTIVE_UNITS:
            raise TrainingError(
                f"the posterior collapsed: {self.active_units} active latent units, "
                f"fewer than {MIN_ACTIVE_UNITS}; lower the weight of the KL"
            )


def measure_perception(
    model: CmVae,
    source: ImageSource,
    indices: Int64[NDArray[np.int64], " K"],
    labels: Labels,  # physical, of those indices
    scale: LabelScale,
    constant: Float32[NDArray[np.float32], "4"],  # physical, what the constant predictor says
) -> PerceptionMetrics:
    """Encode the images at `indices` and compare with their labels."""
    model.eval()
    predicted, means, image_sum = [], [], 0.0
    kl_sum = np.zeros(model.encoder.head.latent_dims)
    with torch.inference_mode():
        for start in range(0, len(indices), BATCH):
            images, _ = source.fetch(indices[start : start + BATCH])
            mean, logvar = model.encoder(images)
            predicted.append(model.pose_decoder(mean).cpu().numpy())
            means.append(mean.cpu().numpy())
            kl_sum += kl_to_standard_normal(mean, logvar).sum(dim=0).cpu().numpy()
            rebuilt = model.image_decoder(mean)
            image_sum += float((rebuilt - images).square().mean()) * len(images)
    errors = np.abs(scale.decode(np.concatenate(predicted)) - labels)
    ranges = labels[:, RANGE]
    in_band = (ranges > BAND_M[0]) & (ranges < BAND_M[1])
    return PerceptionMetrics(
        images=len(indices),
        image_mse=image_sum / len(indices),
        label_mae=tuple(errors.mean(axis=0).tolist()),
        constant_mae=tuple(np.abs(labels - constant).mean(axis=0).tolist()),
        band_mae=tuple(errors[in_band].mean(axis=0).tolist()),
        kl=tuple((kl_sum / len(indices)).tolist()),
        activity=tuple(np.concatenate(means).var(axis=0).tolist()),
    )
