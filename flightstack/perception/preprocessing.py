"""Cut out of a camera's image what the networks see."""

import cv2
import numpy as np

from flightstack.arrays import Rgb, SmallRgb

IMAGE_SIZE = 64  # pixels; the square image of the paper


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
