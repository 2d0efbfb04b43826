"""A small network as a pilot: from an image to velocities; train.py trains it."""

import numpy as np
import torch
from torch import Tensor, nn

from flightstack.gym.gates import velocities_of
from flightstack.records import Observation

WEIGHTS = "learned.pt"  # in the folder where it is trained, and flown


class LearnedPilot(nn.Sequential):
    """A network from images (B, 3, 32, 32) to actions (B, 4), and an end-to-end policy."""

    def __init__(self, weights: str | None = WEIGHTS, **_: object) -> None:
        see = nn.Conv2d(3, 16, 5, 2), nn.ReLU(), nn.Conv2d(16, 32, 3, 2), nn.ReLU(), nn.Flatten()
        super().__init__(*see, nn.Linear(1152, 128), nn.ReLU(), nn.Linear(128, 4))
        if weights is not None:
            self.load_state_dict(torch.load(weights, weights_only=True))

    def reset(self) -> None:
        """Remember nothing."""

    def act(self, observation: Observation) -> np.ndarray:
        """Answer an image by velocities."""
        with torch.inference_mode():
            return velocities_of(self(shrink(observation.image))[0].numpy())


def shrink(image: np.ndarray) -> Tensor:
    """Return what the network sees of an image (64, 64, 3)."""
    return torch.from_numpy(image[::2, ::2].transpose(2, 0, 1) / np.float32(255.0))[None]
