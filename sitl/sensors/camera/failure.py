"""What a failed camera gives: nothing, one picture for ever, chance, or an image now and then."""

import numpy as np

from sitl.records.failures import SLOWER, FailureType, is_gone
from sitl.records.images import Image


class CameraFailure:
    """Stands between the camera and its stream; without a failure everything passes unchanged."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self._type = FailureType.OK
        self._since_us = 0
        self._due = 0  # images, since the first failure
        self._stuck: Image | None = None

    def begin(self, kind: FailureType, time_us: int) -> None:
        """Fail from now on, or be well again."""
        self._type, self._since_us, self._stuck = kind, time_us, None

    def lets_through(self, time_us: int) -> bool:
        """Whether the camera takes the image that is due."""
        kind = self._type
        if kind is FailureType.OK:
            return True
        self._due += 1
        if kind is FailureType.SLOW:
            return self._due % SLOWER == 0
        if kind is FailureType.INTERMITTENT:
            return not is_gone(self._since_us, time_us)
        return kind is not FailureType.OFF

    def spoil(self, image: Image) -> Image:
        """Give the image as it leaves the camera."""
        if self._type is FailureType.GARBAGE:
            rgb = self._rng.integers(0, 256, image.rgb.shape, dtype=np.uint8)
        elif self._type is FailureType.STUCK:
            self._stuck = self._stuck or image
            rgb = self._stuck.rgb
        else:
            return image
        return Image(time_us=image.time_us, sequence=image.sequence, rgb=rgb)
