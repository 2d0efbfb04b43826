"""What becomes of an image on its way out of the camera: blur, noise, freezing, delay."""

from collections import deque

import numpy as np
from numpy.typing import NDArray

from sitl.clock import SECOND_US
from sitl.records.conditions import CameraFaults
from sitl.records.images import Image, ImageStamp
from sitl.sensors.camera.picture import blurred, noisy


class Spoiler:
    """Spoils pictures one after the other; without faults they pass unchanged."""

    def __init__(self, faults: CameraFaults, rng: np.random.Generator) -> None:
        self._faults = faults
        self._rng = rng
        self._shown: NDArray[np.uint8] | None = None

    def spoil(self, rgb: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """Give the picture (H, W, 3) that the camera shows instead of this one."""
        faults = self._faults
        if faults.frozen_frame_share > 0.0:
            is_frozen = self._rng.random() < faults.frozen_frame_share
            if is_frozen and self._shown is not None:
                return self._shown
        if faults.blur_std_px > 0.0:
            rgb = blurred(rgb, faults.blur_std_px)
        if faults.noise_std_levels > 0.0:
            rgb = noisy(rgb, faults.noise_std_levels, self._rng)
        self._shown = rgb
        return rgb


class Delay:
    """Images that are under way: each comes out, its stamp unchanged, a fixed time after it.

    The very first comes out at once, so that whoever waits for an image to begin with gets one.
    """

    def __init__(self, latency_s: float) -> None:
        self._latency_us = round(latency_s * SECOND_US)
        self._under_way: deque[Image] = deque()
        self._is_first = True

    def put(self, image: Image) -> None:
        """Send an image on its way."""
        self._under_way.append(image)

    def is_due(self, time_us: int) -> bool:
        """Whether an image comes out now."""
        if not self._under_way:
            return False
        return self._is_first or time_us - self._under_way[0].time_us >= self._latency_us

    @property
    def first_stamp(self) -> ImageStamp:
        """Time and number of the image that comes out next."""
        first = self._under_way[0]
        return ImageStamp(first.time_us, first.sequence)

    def take(self) -> Image:
        """Take the image that is due."""
        self._is_first = False
        return self._under_way.popleft()
