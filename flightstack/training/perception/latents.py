"""Latent samples of a whole dataset: the trunk once an image, the head as often as wanted."""

import torch
from jaxtyping import Float32
from torch import Generator, Tensor

from flightstack.networks.cmvae import sample_normal
from flightstack.networks.dronet import Dronet, dropout_mask
from flightstack.networks.images import tensor_input
from flightstack.perception.config import FEATURES
from flightstack.training.batches import Images

TRUNK_BATCH = 256
HEAD_BATCH = 4096


class LatentSource:
    """Draws z for every image of a dataset from a frozen encoder's posterior.

    With dropout in the encoder each draw has its own mask; z ~ N(mu, sigma^2) in any case.
    """

    def __init__(self, encoder: Dronet, images: Images, device: torch.device) -> None:
        self._encoder = encoder.to(device).eval()
        self.features = torch.empty(len(images), FEATURES, device=device)  # (K, 512)
        with torch.inference_mode():
            for start in range(0, len(images), TRUNK_BATCH):
                at = torch.arange(start, min(start + TRUNK_BATCH, len(images)))
                rgb = torch.from_numpy(images[at.numpy()]).to(device)
                self.features[at] = encoder.trunk(tensor_input(rgb))

    def draw(self, generator: Generator) -> Float32[Tensor, "K Z"]:
        """Draw one latent sample for every image."""
        with torch.inference_mode():
            starts = range(0, len(self.features), HEAD_BATCH)
            parts = [self._pass(self.features[k : k + HEAD_BATCH], generator) for k in starts]
            return torch.cat(parts)

    def _pass(self, features: Tensor, generator: Generator) -> Tensor:
        if self._encoder.dropout > 0.0:
            features = features * dropout_mask(features, self._encoder.dropout, generator)
        mean, logvar = self._encoder.head(features)
        return sample_normal(mean, logvar, generator)
