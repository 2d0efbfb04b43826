"""What spoils a picture between the lens and the stream: blur and noise."""

import cv2
import numpy as np
from numpy.typing import NDArray


def blurred(image: NDArray[np.uint8], std_px: float) -> NDArray[np.uint8]:
    """Blur an image by a Gaussian."""
    return np.asarray(cv2.GaussianBlur(image, (0, 0), std_px), dtype=np.uint8)


def noisy(
    image: NDArray[np.uint8], std_levels: float, rng: np.random.Generator
) -> NDArray[np.uint8]:
    """Add Gaussian noise, of 255, to each pixel and colour alone."""
    noise = rng.standard_normal(image.shape, dtype=np.float32)
    noise *= np.float32(std_levels)
    return np.asarray(np.clip(np.rint(image + noise), 0, 255), dtype=np.uint8)
