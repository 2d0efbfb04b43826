"""Networks made here, in their flight form."""

from pathlib import Path

import numpy as np

from flightstack.arrays import RgbStack
from flightstack.networks.dronet import Dronet
from flightstack.networks.export import export_encoder, export_policies
from flightstack.networks.policy_stack import PolicyStack
from flightstack.perception.config import PerceptionConfig
from flightstack.perception.encoder import Encoder
from flightstack.perception.labels import LabelScale
from flightstack.policy.config import PolicyConfig
from flightstack.policy.networks import PolicyNetworks

LATENT_DIMS = 10


def pixels(seed: int = 0, count: int = 2) -> RgbStack:
    rng = np.random.default_rng(seed)
    return rng.integers(0, 256, (count, 64, 64, 3), dtype=np.uint8)


def perception_config(*, dropout: float, samples: int) -> PerceptionConfig:
    return PerceptionConfig(
        latent_dims=LATENT_DIMS,
        dropout=dropout,
        sampling="mc-dropout" if dropout else "gaussian",
        samples=samples,
        label_scale=LabelScale(offset=(0.0,) * 4, scale=(1.0,) * 4),
    )


def flown_encoder(folder: Path, network: Dronet) -> Encoder:
    sha256 = export_encoder(folder, network, pixels())
    return Encoder(folder, perception_config(dropout=network.dropout, samples=1), sha256=sha256)


def flown_policies(folder: Path, network: PolicyStack, config: PolicyConfig) -> PolicyNetworks:
    z = np.random.default_rng(0).normal(size=(32, LATENT_DIMS)).astype(np.float32)
    sha256 = export_policies(folder, network, z)
    return PolicyNetworks(folder, config, latent_dims=LATENT_DIMS, sha256=sha256)
