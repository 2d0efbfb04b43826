"""Turn camera bytes into what the encoder reads: float, [-1, 1], channels first."""

import cv2
import numpy as np
import torch
from jaxtyping import Float, Float32, UInt8
from torch import Tensor

from flightstack.arrays import Rgb, RgbStack, SmallRgb

IMAGE_SIZE = 64  # pixels; the square image of the paper
WHITE = 127.5  # half of the byte range: 0..255 becomes -1..1


def fit_image(rgb: Rgb) -> SmallRgb:
    """Cut the middle square out of an image and shrink it to 64 x 64.

    An image of that size passes through untouched: the network sees the bytes it was trained on.
    """
    height, width, _ = rgb.shape
    if height == width == IMAGE_SIZE:
        return rgb
    side = min(height, width)
    top, left = (height - side) // 2, (width - side) // 2
    square = rgb[top : top + side, left : left + side]
    resized = cv2.resize(square, (IMAGE_SIZE, IMAGE_SIZE), interpolation=cv2.INTER_AREA)
    return np.asarray(resized, dtype=np.uint8)


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
