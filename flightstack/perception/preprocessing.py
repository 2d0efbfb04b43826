"""Turn camera bytes into what the encoder reads: float, [-1, 1], channels first."""

import cv2
import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

IMAGE_SIZE = 64  # pixels; the square image of the paper
WHITE = 127.5  # half of the byte range: 0..255 becomes -1..1


def fit_image(rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Cut the middle square out of an image (H, W, 3) of any size and shrink it to 64 x 64.

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


def network_input(rgb: NDArray[np.uint8]) -> Tensor:
    """Scale images with shape (B, 64, 64, 3) to a (B, 3, 64, 64) tensor in [-1, 1].

    The memory stays in (B, H, W, C) order, which is torch's channels_last: nothing is transposed.
    Raises ValueError when the shape or the type is another.
    """
    if rgb.ndim != 4 or rgb.shape[1:] != (IMAGE_SIZE, IMAGE_SIZE, 3) or rgb.dtype != np.uint8:
        raise ValueError(f"images: expected uint8 (B, 64, 64, 3), got {rgb.dtype} {rgb.shape}")
    return tensor_input(torch.from_numpy(np.ascontiguousarray(rgb)))


def tensor_input(rgb: Tensor) -> Tensor:
    """Scale a uint8 tensor with shape (B, 64, 64, 3), on whichever device it lies."""
    return rgb.permute(0, 3, 1, 2).to(torch.float32).div_(WHITE).sub_(1.0)


def image_bytes(images: Tensor) -> NDArray[np.uint8]:
    """Turn network images with shape (B, 3, 64, 64) back into bytes with shape (B, 64, 64, 3)."""
    scaled = images.detach().float().cpu().permute(0, 2, 3, 1).add(1.0).mul(WHITE)
    rgb: NDArray[np.uint8] = scaled.round().clamp(0.0, 255.0).to(torch.uint8).numpy()
    return rgb
