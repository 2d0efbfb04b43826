"""Notice a camera that lies: the same picture for ever, no picture at all, a rate not its own.

Each image by itself is sound; what is wrong shows over time. A complaint lasts until an image takes
it back, so that a vehicle which is held because of it is not released by its own standing still.
On no rung of the ladder does a picture come twice in a row while the vehicle moves (but where half
of them are repeated on purpose), and in the thickest fog the structure is 1.3 levels.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flightstack.arrays import Rgb
from flightstack.records import Image

SUSPICION_US = 1_500_000  # of vehicle time; half of all frames frozen: 30 in a row in 2**30
MOVING_M_S = 0.3
SAMPLES = 64  # rows and columns that are looked at
BLOCK = 8  # samples whose mean has an eighth of the sensor's noise
FLAT_LEVELS = 64  # of 255; what spreads wider than that shows something
MIN_STRUCTURE_LEVELS = 0.5  # spread of the blocks' means
RATE_FACTOR = 3.0  # either way


@dataclass(frozen=True, slots=True, kw_only=True)
class Complaint:
    """What is wrong with the camera, in words, and since when (vehicle time)."""

    what: str
    since_us: int


class ImageWatch:
    """Look at each image once; `announced_hz` is the rate that the camera has said, if it has."""

    def __init__(self, announced_hz: float | None = None) -> None:
        self.complaint: Complaint | None = None
        self._announced_hz = announced_hz
        self._picture: Rgb | None = None
        self._frozen_us: int | None = None  # since when the picture has been the same, in motion
        self._blank_us: int | None = None  # since when nothing has been on it
        self._counted: Image | None = None  # where the counting of the rate begins
        self._odd_rate: Complaint | None = None

    def look(self, image: Image, speed_m_s: float) -> Complaint | None:
        """Take an image and the vehicle's speed; return what is wrong by now."""
        stamp_us = image.stamp_us
        samples = _samples(image.rgb)
        if not self._is_repeated(image.rgb, samples):
            self._frozen_us = None
        elif self._frozen_us is None and speed_m_s >= MOVING_M_S:
            self._frozen_us = stamp_us
        self._picture = image.rgb
        if not is_blank(samples):
            self._blank_us = None
        elif self._blank_us is None:
            self._blank_us = stamp_us
        self._count(image)
        self.complaint = self._judge(stamp_us)
        return self.complaint

    def _judge(self, now_us: int) -> Complaint | None:
        for what, since_us in (
            ("shows nothing", self._blank_us),
            ("shows the same picture again and again", self._frozen_us),
        ):
            if since_us is not None and now_us - since_us > SUSPICION_US:
                return Complaint(what=what, since_us=since_us + SUSPICION_US)
        return self._odd_rate

    def _is_repeated(self, rgb: Rgb, samples: Rgb) -> bool:
        if self._picture is None or self._picture.shape != rgb.shape:
            return False
        return np.array_equal(_samples(self._picture), samples) and np.array_equal(
            self._picture, rgb
        )

    def _count(self, image: Image) -> None:
        """Count images by their own numbers: one that we were too slow for was sent, too."""
        begun = self._counted
        if begun is None or image.sequence <= begun.sequence or image.stamp_us < begun.stamp_us:
            self._counted = image
            return
        lasted_us = image.stamp_us - begun.stamp_us
        if self._announced_hz is None or lasted_us < SUSPICION_US:
            return
        self._counted = image
        rate_hz = (image.sequence - begun.sequence) / (lasted_us / 1e6)
        ratio = rate_hz / self._announced_hz
        if 1 / RATE_FACTOR <= ratio <= RATE_FACTOR:
            self._odd_rate = None
        elif self._odd_rate is None:
            what = f"gives {rate_hz:.1f} images a second, not {self._announced_hz:g}"
            self._odd_rate = Complaint(what=what, since_us=image.stamp_us)


def is_blank(samples: Rgb) -> bool:
    """Whether an image of at most SAMPLES rows and columns is uniform to the sensor's noise."""
    if int(samples.max()) - int(samples.min()) > FLAT_LEVELS:
        return False
    return structure_levels(samples) < MIN_STRUCTURE_LEVELS


def structure_levels(samples: Rgb) -> float:
    """Give the spread of blocks' means, in levels of 255, of the colour that spreads widest."""
    return float(_block_means(samples).std(axis=(0, 1)).max())


def _block_means(samples: Rgb) -> NDArray[np.float64]:
    rows, columns = (max(1, size // BLOCK) for size in samples.shape[:2])
    tall, wide = samples.shape[0] // rows, samples.shape[1] // columns
    whole = samples[: rows * tall, : columns * wide].astype(np.float64)
    means: NDArray[np.float64] = whole.reshape(rows, tall, columns, wide, 3).mean(axis=(1, 3))
    return means


def _samples(rgb: Rgb) -> Rgb:
    """Take at most SAMPLES rows and columns, evenly."""
    steps = (-(-size // SAMPLES) for size in rgb.shape[:2])
    tall, wide = steps
    return rgb[::tall, ::wide]
