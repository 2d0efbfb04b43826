"""The ensemble's networks as they fly: latent samples to means and variances, in network units."""

from pathlib import Path
from typing import NamedTuple

import numpy as np
from jaxtyping import Float32
from numpy.typing import NDArray

from flightstack.arrays import Latents
from flightstack.inference.graph import Graph, Signature
from flightstack.policy.config import PolicyConfig
from flightstack.records import VELOCITIES

POLICIES_FILE = "policies.onnx"
LATENTS, MEAN, VAR = "z", "mean", "var"

Outputs = Float32[NDArray[np.float32], "N M 4"]


class Moments(NamedTuple):
    """What N members say of M latent samples, in network units."""

    mean: Outputs
    var: Outputs


def policies_signature(members: int, latent_dims: int) -> Signature:
    """Return what the networks of N members take and give."""
    said = (members, None, len(VELOCITIES))
    return Signature(inputs={LATENTS: (None, latent_dims)}, outputs={MEAN: said, VAR: said})


class PolicyNetworks:
    """N networks as one graph; a pure function of the latents."""

    def __init__(
        self, folder: Path, config: PolicyConfig, *, latent_dims: int, sha256: str
    ) -> None:
        """Load them from a model's folder; raises ModelError."""
        signature = policies_signature(config.members, latent_dims)
        self._graph = Graph(folder / POLICIES_FILE, sha256=sha256, signature=signature)

    def moments(self, z: Latents) -> Moments:
        """Pass latents through every member."""
        return Moments(*self._graph.run([MEAN, VAR], {LATENTS: z}))
