"""Pictures of files on surfaces: the ground's as light and dark, a gate's as it is."""

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from sitl.errors import UsageError

SIZE_PX = 256  # a power of two, as look.TEXTURE_SIZE


@cache
def read_texture(path: str) -> NDArray[np.float32]:
    """Read a picture as a texture of shape (256, 256), values in 0..1; mirrored, so that it tiles.

    Raises UsageError where it cannot be read.
    """
    grey = cv2.cvtColor(_read(path), cv2.COLOR_BGR2GRAY)
    half = cv2.resize(grey, (SIZE_PX // 2, SIZE_PX // 2), interpolation=cv2.INTER_AREA)
    tile = np.hstack([half, half[:, ::-1]]).astype(np.float32)
    tile = np.vstack([tile, tile[::-1]])
    low, high = np.quantile(tile, [0.01, 0.99])
    return np.asarray(np.clip((tile - low) / max(high - low, 1.0), 0.0, 1.0), dtype=np.float32)


@contextmanager
def readable(path: str) -> Iterator[str]:
    """Give a picture's path as the renderer reads it: PNG, square; raises UsageError."""
    square = cv2.resize(_read(path), (SIZE_PX, SIZE_PX), interpolation=cv2.INTER_AREA)
    with tempfile.TemporaryDirectory() as folder:
        copy = str(Path(folder, "picture.png"))
        cv2.imwrite(copy, square)
        yield copy


def _read(path: str) -> NDArray[np.uint8]:
    picture = cv2.imread(path, cv2.IMREAD_COLOR) if Path(path).is_file() else None
    if picture is None:
        raise UsageError(f"scenery: {path} is no picture that can be read")
    return np.asarray(picture, dtype=np.uint8)
