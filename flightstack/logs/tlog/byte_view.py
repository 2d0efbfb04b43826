"""See what stands at every place of some bytes, without copying them."""

from typing import Any

import numpy as np
from numpy.typing import NDArray


def at_every_byte(data: NDArray[np.uint8], dtype: str) -> NDArray[Any]:
    """Return a view with one item of this type for each byte of `data` that one can start at."""
    count = len(data) - np.dtype(dtype).itemsize + 1
    return np.ndarray((count,), dtype=dtype, buffer=data, strides=(1,))
