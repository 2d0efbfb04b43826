"""The Dronet encoder: a deterministic trunk, one dropout slot, and a small head.

References:
    Loquercio et al. 2018, "DroNet: Learning to Fly by Driving".
    Bonatti et al. 2020, "Learning visuomotor policies for aerial navigation using cross-modal
    representations": the layer sizes.
    Gal and Ghahramani 2016, "Dropout as a Bayesian approximation": the slot's masks.
"""

import torch
from torch import Generator, Tensor, nn

from flightstack.networks.tensors import (
    Alike,
    FeatureTensor,
    HalvedMaps,
    ImageTensor,
    LatentTensor,
    MapTensor,
)
from flightstack.perception.config import FEATURES

LOGVAR_RANGE = (-12.0, 6.0)  # keeps exp() finite however wrong the weights are


class ResidualBlock(nn.Module):
    """Pre-activation, halving the image: BN-ReLU-conv/2-BN-ReLU-conv plus a 1x1/2 shortcut."""

    def __init__(self, channels_in: int, channels_out: int) -> None:
        super().__init__()
        self.norm1 = nn.BatchNorm2d(channels_in)
        self.conv1 = nn.Conv2d(channels_in, channels_out, 3, stride=2, padding=1)
        self.norm2 = nn.BatchNorm2d(channels_out)
        self.conv2 = nn.Conv2d(channels_out, channels_out, 3, padding=1)
        self.shortcut = nn.Conv2d(channels_in, channels_out, 1, stride=2)

    def forward(self, x: MapTensor) -> HalvedMaps:
        """Map to half the height and width."""
        inner = self.conv1(torch.relu(self.norm1(x)))
        inner = self.conv2(torch.relu(self.norm2(inner)))
        out: Tensor = inner + self.shortcut(x)
        return out


class Trunk(nn.Module):
    """All that stands before the dropout slot; with batch norm in eval mode it is deterministic."""

    def __init__(self) -> None:
        super().__init__()
        self.conv = nn.Conv2d(3, 32, 5, stride=2, padding=2)
        self.pool = nn.MaxPool2d(2)
        self.blocks = nn.Sequential(
            ResidualBlock(32, 32), ResidualBlock(32, 64), ResidualBlock(64, 128)
        )

    def forward(self, images: ImageTensor) -> FeatureTensor:
        """Map images in [-1, 1] to features."""
        maps = self.blocks(self.pool(self.conv(images)))
        return torch.relu(maps.flatten(1))


class Head(nn.Module):
    """All that stands after the dropout slot: 512-64-32-2Z."""

    def __init__(self, latent_dims: int) -> None:
        super().__init__()
        self.latent_dims = latent_dims
        self.dense1 = nn.Linear(FEATURES, 64)
        self.dense2 = nn.Linear(64, 32)
        self.out = nn.Linear(32, 2 * latent_dims)

    def forward(self, features: FeatureTensor) -> tuple[LatentTensor, LatentTensor]:
        """Map features, masked or not, to mean and log-variance."""
        hidden = torch.relu(self.dense1(features))
        hidden = torch.relu(self.dense2(hidden))
        out = self.out(hidden)
        mean, logvar = out[..., : self.latent_dims], out[..., self.latent_dims :]
        return mean, logvar.clamp(*LOGVAR_RANGE)


class Dronet(nn.Module):
    """Image to the mean and log-variance of q(z|x); `dropout` is the slot's rate, 0 for none."""

    def __init__(self, *, latent_dims: int, dropout: float) -> None:
        super().__init__()
        self.dropout = dropout
        self.trunk = Trunk()
        self.head = Head(latent_dims)

    def forward(
        self, images: ImageTensor, generator: Generator | None = None
    ) -> tuple[LatentTensor, LatentTensor]:
        """Encode images; with a generator each image gets a dropout mask of its own."""
        features = self.trunk(images)
        if generator is not None and self.dropout > 0.0:
            features = features * dropout_mask(features, self.dropout, generator)
        mean, logvar = self.head(features)
        return mean, logvar


def dropout_mask(like: Alike, rate: float, generator: Generator) -> Alike:
    """Draw 0 with probability `rate` and 1 / (1 - rate) otherwise, shaped like `like`."""
    kept = torch.rand(like.shape, generator=generator, device=like.device) >= rate
    return kept.to(like.dtype).div_(1.0 - rate)
