"""The encoder's trunk as it flies: the same arithmetic without what only training needs.

On one image torch's modules cost a third as much as the layers themselves. So the tensors are
taken out of them once, the norm between two convolutions becomes part of the first, and what
nobody reads again is overwritten.
"""

from typing import NamedTuple, Self

import torch
from jaxtyping import Float
from torch import Tensor, nn
from torch.nn import functional
from torch.nn.utils.fusion import fuse_conv_bn_eval

from flightstack.perception.dronet import ResidualBlock, Trunk
from flightstack.perception.tensors import FeatureTensor, HalvedMaps, ImageTensor, MapTensor


class Convolution(NamedTuple):
    """The tensors of a convolution."""

    weight: Float[Tensor, "O I k k"]
    bias: Float[Tensor, " O"] | None

    @classmethod
    def of(cls, layer: nn.Conv2d) -> Self:
        """Take them out of a layer."""
        return cls(layer.weight.detach(), None if layer.bias is None else layer.bias.detach())


class Block(NamedTuple):
    """A `ResidualBlock`, its second norm folded into its first convolution."""

    norm1: nn.BatchNorm2d
    conv1: Convolution
    conv2: Convolution
    shortcut: Convolution

    @classmethod
    def of(cls, block: ResidualBlock) -> Self:
        """Take a trained block apart."""
        return cls(
            block.norm1,
            Convolution.of(fuse_conv_bn_eval(block.conv1, block.norm2)),
            Convolution.of(block.conv2),
            Convolution.of(block.shortcut),
        )

    def __call__(self, maps: MapTensor) -> HalvedMaps:
        """Map to half the height and width."""
        norm = self.norm1
        inner = functional.batch_norm(
            maps, norm.running_mean, norm.running_var, norm.weight, norm.bias, eps=norm.eps
        )
        inner = torch.conv2d(torch.relu_(inner), *self.conv1, stride=2, padding=1)
        inner = torch.conv2d(torch.relu_(inner), *self.conv2, padding=1)
        return inner.add_(torch.conv2d(maps, *self.shortcut, stride=2))


class FlightTrunk:
    """A trained trunk, for inference alone; it keeps the weights that it was made with."""

    def __init__(self, trunk: Trunk) -> None:
        """Take a trunk in eval mode apart."""
        self._first = Convolution.of(trunk.conv)
        self._blocks = [
            Block.of(block) for block in trunk.blocks if isinstance(block, ResidualBlock)
        ]

    def __call__(self, images: ImageTensor) -> FeatureTensor:
        """Map images in [-1, 1] to features."""
        maps = torch.max_pool2d(torch.conv2d(images, *self._first, stride=2, padding=2), 2)
        for block in self._blocks:
            maps = block(maps)
        return torch.relu(maps.flatten(1))
