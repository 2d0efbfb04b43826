"""Read the gate's pose out of images, as the encoder's latent mean tells it; numpy in and out."""

import numpy as np
import torch

from flightstack.arrays import PerImage, RgbStack
from flightstack.perception.decoders import GatePoseDecoder
from flightstack.perception.dronet import Dronet
from flightstack.perception.labels import LabelScale
from flightstack.perception.preprocessing import network_input

BATCH = 256


def read_poses(
    encoder: Dronet, decoder: GatePoseDecoder, scale: LabelScale, rgb: RgbStack
) -> PerImage:
    """Map images to poses: range, azimuth, elevation, gate yaw; m, rad."""
    scaled = []
    with torch.inference_mode():
        for start in range(0, len(rgb), BATCH):
            mean, _ = encoder(network_input(rgb[start : start + BATCH]))
            scaled.append(decoder(mean).numpy())
    return scale.decode(np.concatenate(scaled))
