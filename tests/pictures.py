"""Pictures as the tests look at them: decoded, and there."""

from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray


def pixels(path: Path) -> NDArray[Any]:
    """A picture's file as (H, W, 3), BGR."""
    return decoded(path.read_bytes())


def decoded(data: bytes) -> NDArray[Any]:
    """A coded picture as (H, W, 3), BGR."""
    image = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    assert image is not None
    return image
