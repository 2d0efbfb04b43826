"""What the camera took, and when."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray


class ImageStamp(NamedTuple):
    """When an image was taken, and its number."""

    time_us: int
    sequence: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Image:
    """One camera image."""

    time_us: int
    sequence: int
    rgb: NDArray[np.uint8]  # (H, W, 3)
