"""The gate detector's network: an image to what each of 16 x 16 cells knows of a gate in it.

A small pyramid: down to 4 x 4 for what is large and near, and up again for what is small and far.
Each cell gives a score, the centre's place in it, the logarithm of the distance, twice the angle
under which the gate is seen (as a vector, since the angle counts modulo pi), and a log-variance of
each: a heteroscedastic regression (Seitzer et al. 2022 say how to train it).
"""

import torch
from jaxtyping import Float
from torch import Tensor, nn

from flightstack.perception.gate_decoding import OUTPUTS

SCORE, CENTRE, RANGE, ANGLE, LOGVARS = 0, slice(1, 3), 3, slice(4, 6), slice(6, 10)
# log-variances: of u, v, the logarithm of the distance, twice the angle
LOGVAR_SPAN = (-9.0, 4.0)
CHANNELS = (16, 32, 64, 96)

CellTensor = Float[Tensor, "B 10 16 16"]


class _Residual(nn.Module):
    """conv-norm-ReLU-conv-norm beside its input."""

    def __init__(self, channels: int) -> None:
        super().__init__()
        self.inner = nn.Sequential(
            nn.Conv2d(channels, channels, 3, padding=1, bias=False),
            nn.BatchNorm2d(channels),
            nn.ReLU(inplace=True),
            nn.Conv2d(channels, channels, 3, padding=1, bias=False),
            nn.BatchNorm2d(channels),
        )

    def forward(self, maps: Tensor) -> Tensor:
        return torch.relu(maps + self.inner(maps))


def _down(channels_in: int, channels_out: int, kernel: int = 3) -> nn.Sequential:
    return nn.Sequential(
        nn.Conv2d(channels_in, channels_out, kernel, stride=2, padding=kernel // 2, bias=False),
        nn.BatchNorm2d(channels_out),
        nn.ReLU(inplace=True),
    )


class GateNetwork(nn.Module):
    """Images in [-1, 1] to cells; log-variances are bounded."""

    def __init__(self) -> None:
        super().__init__()
        first, fine, middle, coarse = CHANNELS
        self.stem = nn.Sequential(_down(3, first, 5), _down(first, fine), _Residual(fine))
        self.middle = nn.Sequential(_down(fine, middle), _Residual(middle))
        self.coarse = nn.Sequential(_down(middle, coarse), _Residual(coarse), _Residual(coarse))
        self.up_coarse = nn.Conv2d(coarse, middle, 1)
        self.mix_middle = _Residual(middle)
        self.up_middle = nn.Conv2d(middle, fine, 1)
        self.mix_fine = _Residual(fine)
        self.head = nn.Sequential(
            nn.Conv2d(fine, 48, 3, padding=1), nn.ReLU(inplace=True), nn.Conv2d(48, OUTPUTS, 1)
        )

    def forward(self, images: Float[Tensor, "B 3 64 64"]) -> CellTensor:
        """Map images to cells."""
        fine = self.stem(images)
        middle = self.middle(fine)
        coarse = self.coarse(middle)
        middle = self.mix_middle(middle + _twice(self.up_coarse(coarse)))
        fine = self.mix_fine(fine + _twice(self.up_middle(middle)))
        cells: Tensor = self.head(fine)
        logvars = cells[:, LOGVARS].clamp(*LOGVAR_SPAN)
        return torch.cat((cells[:, : LOGVARS.start], logvars), dim=1)


def _twice(maps: Tensor) -> Tensor:
    return nn.functional.interpolate(maps, scale_factor=2.0, mode="nearest")
