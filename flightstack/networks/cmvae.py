"""The cross-modal variational autoencoder: one latent space for the image and the gate's pose.

    L = alpha/2 mean |x - x_hat|^2 + gamma/2 sum_k w_k (xi_k - xi_hat_k)^2
        + beta KL( q(z|x) || N(0, I) )

with the mean over pixels, the sum over the scaled labels, and the KL summed over the latent
dimensions, all averaged over the batch.

References:
    Bonatti et al. 2020 (see dronet.py): the architecture. Its KL takes sigma for a log-variance;
    here it is the correct one, and so the weights differ.
"""

from dataclasses import dataclass

import torch
from jaxtyping import Float
from torch import Generator, Tensor, nn

from flightstack.networks.decoders import GatePoseDecoder, ImageDecoder
from flightstack.networks.dronet import Dronet
from flightstack.networks.tensors import Alike, ImageTensor
from flightstack.perception.labels import LABELS


@dataclass(frozen=True, slots=True, kw_only=True)
class LossWeights:
    """The weights of the loss in the module's docstring."""

    image: float = 5.0  # alpha: enough for the horizon and a second gate to reach the latents
    pose: float = 1.0  # gamma
    kl: float = 1e-3  # beta
    labels: tuple[float, ...] = (1.0, 1.0, 1.0, 2.0)  # w_k; gate yaw collapses to 0 when underfed


@dataclass(frozen=True, slots=True, kw_only=True)
class LossTerms:
    """The parts of the loss of one batch, each before its weight."""

    image: Float[Tensor, ""]  # mean squared error of a pixel
    pose: Float[Tensor, "4"]  # mean squared error of each scaled label
    kl: Float[Tensor, " Z"]  # nats

    def total(self, weights: LossWeights) -> Float[Tensor, ""]:
        """Weigh and add up."""
        pose = (self.pose * self.pose.new_tensor(weights.labels)).sum()
        return 0.5 * (weights.image * self.image + weights.pose * pose) + weights.kl * self.kl.sum()


class CmVae(nn.Module):
    """Encoder, image decoder and gate-pose decoder, trained together."""

    def __init__(self, *, latent_dims: int, dropout: float) -> None:
        super().__init__()
        self.encoder = Dronet(latent_dims=latent_dims, dropout=dropout)
        self.image_decoder = ImageDecoder(latent_dims)
        self.pose_decoder = GatePoseDecoder(len(LABELS))

    def loss_terms(
        self,
        images: ImageTensor,
        labels: Float[Tensor, "B 4"],
        *,
        generator: Generator,
        reconstructed: int,
    ) -> LossTerms:
        """Pass a batch through, with fresh dropout masks and one latent sample an image.

        The image term is estimated on the first `reconstructed` images: the image decoder costs
        more than all the rest.
        """
        mean, logvar = (part.float() for part in self.encoder(images, generator))
        z = sample_normal(mean, logvar, generator)
        pose = self.pose_decoder(z).float()
        rebuilt = self.image_decoder(z[:reconstructed]).float()
        return LossTerms(
            image=(rebuilt - images[:reconstructed]).square().mean(),
            pose=(pose - labels).square().mean(dim=0),
            kl=kl_to_standard_normal(mean, logvar).mean(dim=0),
        )


def kl_to_standard_normal(mean: Alike, logvar: Alike) -> Alike:
    """KL( N(mean, exp(logvar)) || N(0, 1) ) elementwise, in nats (Kingma and Welling 2014)."""
    return 0.5 * (mean.square() + logvar.exp() - 1.0 - logvar)


def sample_normal(mean: Alike, logvar: Alike, generator: Generator) -> Alike:
    """Draw one sample from each N(mean, exp(logvar))."""
    noise = torch.randn(mean.shape, generator=generator, device=mean.device, dtype=mean.dtype)
    return mean + noise * torch.exp(0.5 * logvar)
