"""Draw what a CM-VAE has learned: reconstructions, and a walk along every latent dimension."""

from pathlib import Path

import cv2
import numpy as np
import torch
from jaxtyping import UInt8
from numpy.typing import NDArray

from flightstack.networks.cmvae import CmVae
from flightstack.networks.images import image_bytes
from flightstack.networks.tensors import ImageTensor

ZOOM = 2
TRAVERSAL = np.linspace(-2.5, 2.5, 11)  # standard deviations of the prior


def write_reconstructions(model: CmVae, images: ImageTensor, path: Path) -> None:
    """Write the images above what the decoder makes of their latent mean."""
    with torch.inference_mode():
        mean, _ = model.encoder(images)
        rebuilt = model.image_decoder(mean)
    _write(np.stack([image_bytes(images), image_bytes(rebuilt)]), path)


def write_traversals(model: CmVae, images: ImageTensor, path: Path) -> None:
    """Write one row a latent dimension: the first image's latent with that dimension swept."""
    with torch.inference_mode():
        mean, _ = model.encoder(images[:1])
        dims, steps = mean.shape[1], len(TRAVERSAL)
        z = mean.repeat(dims * steps, 1)
        for dim in range(dims):
            row = slice(dim * steps, (dim + 1) * steps)
            z[row, dim] = torch.as_tensor(TRAVERSAL, dtype=z.dtype, device=z.device)
        rebuilt = image_bytes(model.image_decoder(z))
    _write(rebuilt.reshape(dims, steps, *rebuilt.shape[1:]), path)


def _write(grid: UInt8[NDArray[np.uint8], "rows columns H W 3"], path: Path) -> None:
    """Write a grid of images as one picture."""
    rows, columns, height, width, _ = grid.shape
    sheet = grid.transpose(0, 2, 1, 3, 4).reshape(rows * height, columns * width, 3)
    sheet = sheet.repeat(ZOOM, axis=0).repeat(ZOOM, axis=1)
    cv2.imwrite(str(path), cv2.cvtColor(sheet, cv2.COLOR_RGB2BGR))
