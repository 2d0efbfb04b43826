"""Fetch batches of images and labels, mirrored at random, from disk or from the accelerator."""

from collections.abc import Iterator
from typing import Protocol, runtime_checkable

import numpy as np
import torch
from jaxtyping import Float32, Int64
from numpy.typing import NDArray
from torch import Generator, Tensor

from flightstack.arrays import Labels, RgbStack
from flightstack.networks.images import tensor_input


@runtime_checkable
class Images(Protocol):
    """What can be gathered from by indices: an array, or a dataset's shards."""

    def __len__(self) -> int:
        """How many images there are."""
        ...

    def __getitem__(self, at: NDArray[np.int64]) -> RgbStack:
        """Images in the order of `at`."""
        ...


class ImageSource:
    """Images and scaled labels of one dataset; on an accelerator everything is uploaded once."""

    def __init__(
        self,
        images: Images,
        labels: Labels,  # scaled
        device: torch.device,
    ) -> None:
        self._device = device
        self._labels = torch.from_numpy(np.ascontiguousarray(labels)).to(device)
        self._images = images
        self._resident: Tensor | None = None
        if device.type != "cpu":
            self._resident = torch.from_numpy(images[np.arange(len(images))]).to(device)

    def fetch(
        self, indices: Int64[NDArray[np.int64], " B"]
    ) -> tuple[Float32[Tensor, "B 3 64 64"], Float32[Tensor, "B 4"]]:
        """Images in [-1, 1] and scaled labels."""
        at = torch.from_numpy(indices).to(self._device)
        if self._resident is None:
            rgb = torch.from_numpy(self._images[indices])
        else:
            rgb = self._resident[at]
        return tensor_input(rgb), self._labels[at]


def shuffled(
    indices: NDArray[np.int64], batch: int, seed: list[int]
) -> Iterator[NDArray[np.int64]]:
    """Yield full batches of `indices` in the order of `seed`; the rest waits for another order."""
    order = np.random.default_rng(seed).permutation(indices)
    for start in range(0, len(order) - batch + 1, batch):
        yield order[start : start + batch]


def mirror(
    images: Float32[Tensor, "B 3 H W"],
    labels: Float32[Tensor, "B 4"],
    signs: Float32[Tensor, "4"],
    generator: Generator,
) -> tuple[Float32[Tensor, "B 3 H W"], Float32[Tensor, "B 4"]]:
    """Flip half of the images left-right, and with them the labels whose sign is -1."""
    flip = torch.rand(len(images), generator=generator, device=images.device) < 0.5
    images = torch.where(flip[:, None, None, None], images.flip(3), images)
    labels = torch.where(flip[:, None], labels * signs, labels)
    return images, labels
