"""The two decoders that give the latent space its meaning: the image and the gate's pose.

Reference: Bonatti et al. 2020 (see dronet.py). Only z0..z3 reach the pose, one label each; the
whole of z reaches the image: that is the disentangling constraint.
"""

import torch
from jaxtyping import Float
from torch import Tensor, nn

from flightstack.networks.tensors import ImageTensor, LatentTensor


class PointToMap(nn.ConvTranspose2d):
    """A transposed convolution of a 1x1 map, which is one matrix product and so much faster."""

    def forward(
        self,
        x: Float[Tensor, "B C"],
        output_size: list[int] | None = None,  # noqa: ARG002
    ) -> Float[Tensor, "B c k k"]:
        """Spread every point over a map as large as the kernel."""
        size = self.kernel_size[0]
        flat = x @ self.weight.permute(0, 2, 3, 1).reshape(self.in_channels, -1)
        maps = flat.view(-1, size, size, self.out_channels)
        maps = maps if self.bias is None else maps + self.bias
        return maps.permute(0, 3, 1, 2)


class ImageDecoder(nn.Module):
    """z to an image in [-1, 1]: dense 1024, six transposed convolutions."""

    def __init__(self, latent_dims: int) -> None:
        super().__init__()
        self.dense = nn.Linear(latent_dims, 1024)
        self.maps = nn.Sequential(
            PointToMap(1024, 128, 4),  # 4 x 4
            nn.ReLU(),
            nn.ConvTranspose2d(128, 64, 4, stride=2, padding=1),  # 8 x 8
            nn.ReLU(),
            nn.ConvTranspose2d(64, 64, 3, padding=1),
            nn.ReLU(),
            nn.ConvTranspose2d(64, 32, 4, stride=2, padding=1),  # 16 x 16
            nn.ReLU(),
            nn.ConvTranspose2d(32, 32, 4, stride=2, padding=1),  # 32 x 32
            nn.ReLU(),
            nn.ConvTranspose2d(32, 3, 4, stride=2, padding=1),  # 64 x 64
            nn.Tanh(),
        )

    def forward(self, z: LatentTensor) -> ImageTensor:
        """Reconstruct the image."""
        image: Tensor = self.maps(torch.relu(self.dense(z)))
        return image


class GatePoseDecoder(nn.Module):
    """z0..z3 to the four normalised gate labels, each by its own 1-64-32-1 network."""

    def __init__(self, labels: int) -> None:
        super().__init__()
        self.heads = nn.ModuleList(
            nn.Sequential(
                nn.Linear(1, 64), nn.ReLU(), nn.Linear(64, 32), nn.ReLU(), nn.Linear(32, 1)
            )
            for _ in range(labels)
        )

    def forward(self, z: LatentTensor) -> Float[Tensor, "B L"]:
        """Read each label from its own dimension."""
        return torch.cat([head(z[:, k : k + 1]) for k, head in enumerate(self.heads)], dim=1)
