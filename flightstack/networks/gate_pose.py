"""Read the gate's pose out of images, as the encoder's latent mean tells it; numpy in and out."""

import numpy as np
import torch

from flightstack.arrays import PerImage, RgbStack
from flightstack.networks.images import network_input
from flightstack.networks.trained import TrainedModel

BATCH = 256


def read_poses(model: TrainedModel, rgb: RgbStack) -> PerImage:
    """Map images to poses: range, azimuth, elevation, gate yaw; m, rad."""
    scaled = []
    with torch.inference_mode():
        for start in range(0, len(rgb), BATCH):
            mean, _ = model.encoder(network_input(rgb[start : start + BATCH]))
            scaled.append(model.pose_decoder(mean).numpy())
    return model.config.perception.label_scale.decode(np.concatenate(scaled))
