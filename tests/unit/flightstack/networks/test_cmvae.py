import numpy as np
import pytest
import torch
from torch.distributions import Normal, kl_divergence

from flightstack.networks.cmvae import (
    CmVae,
    LossTerms,
    LossWeights,
    kl_to_standard_normal,
    sample_normal,
)
from flightstack.networks.decoders import PointToMap
from flightstack.networks.dronet import Dronet


def seeded(seed: int) -> torch.Generator:
    return torch.Generator().manual_seed(seed)


def test_kl_is_torchs_own() -> None:
    mean, logvar = torch.randn(6, 10, generator=seeded(0)), torch.randn(6, 10, generator=seeded(1))
    reference = kl_divergence(Normal(mean, torch.exp(0.5 * logvar)), Normal(0.0, 1.0))
    torch.testing.assert_close(kl_to_standard_normal(mean, logvar), reference)


def test_samples_have_the_moments_asked_for() -> None:
    mean, logvar = torch.full((100_000,), 2.0), torch.full((100_000,), np.log(0.25))
    z = sample_normal(mean, logvar, seeded(0))
    assert float(z.mean()) == pytest.approx(2.0, abs=0.01)
    assert float(z.std()) == pytest.approx(0.5, abs=0.01)


def test_encoder_has_the_lineages_size() -> None:
    encoder = Dronet(latent_dims=10, dropout=0.2)
    assert sum(p.numel() for p in encoder.parameters()) == pytest.approx(346_000, rel=0.01)


def test_each_label_sees_one_latent_dimension_alone() -> None:
    model = CmVae(latent_dims=10, dropout=0.0)
    z = torch.randn(1, 10, generator=seeded(0), requires_grad=True)
    for label in range(4):
        (gradient,) = torch.autograd.grad(model.pose_decoder(z)[0, label], z)
        assert torch.nonzero(gradient[0]).flatten().tolist() == [label]


def test_image_comes_back_in_range_and_shape() -> None:
    image = CmVae(latent_dims=10, dropout=0.0).image_decoder(3.0 * torch.randn(2, 10))
    assert image.shape == (2, 3, 64, 64)
    assert float(image.detach().abs().max()) <= 1.0


def test_point_to_map_is_the_transposed_convolution() -> None:
    layer, x = PointToMap(8, 3, 4), torch.randn(5, 8, generator=seeded(0))
    reference = torch.nn.functional.conv_transpose2d(x[:, :, None, None], layer.weight, layer.bias)
    torch.testing.assert_close(layer(x), reference)


def test_loss_weighs_each_term() -> None:
    terms = LossTerms(
        image=torch.tensor(2.0),
        pose=torch.tensor([1.0, 2.0, 3.0, 4.0]),
        kl=torch.tensor([5.0, 6.0]),
    )
    weights = LossWeights(image=3.0, pose=0.5, kl=0.1, labels=(1.0, 0.0, 0.0, 2.0))
    assert float(terms.total(weights)) == pytest.approx(0.5 * (3.0 * 2.0 + 0.5 * 9.0) + 0.1 * 11.0)


def test_loss_is_a_function_of_its_generator() -> None:
    model = CmVae(latent_dims=10, dropout=0.5)
    images, labels = torch.rand(4, 3, 64, 64), torch.zeros(4, 4)

    def loss(seed: int) -> float:
        model.eval()
        terms = model.loss_terms(images, labels, generator=seeded(seed), reconstructed=2)
        return float(terms.total(LossWeights()).detach())

    assert loss(1) == loss(1)
    assert loss(1) != loss(2)
