"""Turn images into what networks read, and back: float, [-1, 1], channels first; and in batches."""

import numpy as np
import torch
from jaxtyping import Float, Float32, UInt8
from torch import Tensor

from flightstack.arrays import RgbStack
from flightstack.perception.preprocessing import IMAGE_SIZE

WHITE = 127.5  # half of the byte range: 0..255 becomes -1..1


def network_input(rgb: RgbStack) -> Float32[Tensor, "K 3 64 64"]:
    """Scale images to a tensor in [-1, 1].

    The memory stays in the bytes' order, which is torch's channels_last: nothing is transposed.
    Raises ValueError when the shape or the type is another.
    """
    if rgb.ndim != 4 or rgb.shape[1:] != (IMAGE_SIZE, IMAGE_SIZE, 3) or rgb.dtype != np.uint8:
        raise ValueError(f"images: expected uint8 (B, 64, 64, 3), got {rgb.dtype} {rgb.shape}")
    return tensor_input(torch.from_numpy(np.ascontiguousarray(rgb)))


def tensor_input(rgb: UInt8[Tensor, "B 64 64 3"]) -> Float32[Tensor, "B 3 64 64"]:
    """Scale a tensor of bytes, on whichever device it lies."""
    return rgb.permute(0, 3, 1, 2).to(torch.float32).div_(WHITE).sub_(1.0)


def image_bytes(images: Float[Tensor, "K 3 64 64"]) -> RgbStack:
    """Turn network images back into bytes."""
    scaled = images.detach().float().cpu().permute(0, 2, 3, 1).add(1.0).mul(WHITE)
    rgb: RgbStack = scaled.round().clamp(0.0, 255.0).to(torch.uint8).numpy()
    return rgb
