import numpy as np
import pytest
import torch
from numpy.typing import NDArray

from flightstack.perception.config import PerceptionConfig
from flightstack.perception.dronet import Dronet, dropout_mask
from flightstack.perception.labels import LabelScale
from flightstack.perception.posterior import (
    GaussianPosterior,
    McDropoutPosterior,
    MeanPosterior,
    make_posterior,
)
from flightstack.perception.preprocessing import network_input

SAMPLES, RATE = 32, 0.2


@pytest.fixture
def encoder() -> Dronet:
    """An encoder whose head is wide awake, with batch-norm statistics of its own."""
    torch.manual_seed(0)
    encoder = Dronet(latent_dims=10, dropout=RATE)
    encoder.train()
    with torch.no_grad():
        encoder.trunk(torch.rand(16, 3, 64, 64) * 2.0 - 1.0)
    return encoder.eval()


@pytest.fixture
def rgb() -> NDArray[np.uint8]:
    return np.random.default_rng(0).integers(0, 256, (64, 64, 3), dtype=np.uint8)


def test_trunk_once_equals_full_passes_with_the_same_masks(
    encoder: Dronet, rgb: NDArray[np.uint8]
) -> None:
    posterior = McDropoutPosterior(encoder, seeded(7), samples=SAMPLES, within=False)
    found = posterior.sample(rgb)

    masks = dropout_mask(torch.empty(SAMPLES, 512), RATE, seeded(7))
    images = network_input(rgb[np.newaxis])
    with torch.inference_mode():
        expected = [encoder.head(encoder.trunk(images) * mask)[0].numpy()[0] for mask in masks]
    np.testing.assert_allclose(found, np.stack(expected), atol=1e-5)
    assert found.std(axis=0).min() > 0.0  # the masks do matter


def test_pass_draws_z_from_its_own_gaussian(encoder: Dronet, rgb: NDArray[np.uint8]) -> None:
    found = McDropoutPosterior(encoder, seeded(7), samples=SAMPLES).sample(rgb)
    generator = seeded(7)
    mask = dropout_mask(torch.empty(SAMPLES, 512), RATE, generator)
    noise = torch.randn(SAMPLES, 10, generator=generator)
    with torch.inference_mode():
        features = encoder.trunk(network_input(rgb[np.newaxis]))
        mean, logvar = encoder.head(features * mask)
    expected = mean + noise * torch.exp(0.5 * logvar)
    np.testing.assert_allclose(found, expected.numpy(), atol=1e-5)


def test_gaussian_samples_have_the_encoders_moments(
    encoder: Dronet, rgb: NDArray[np.uint8]
) -> None:
    found = GaussianPosterior(encoder, seeded(1), samples=20_000).sample(rgb)
    with torch.inference_mode():
        mean, logvar = (part.numpy()[0] for part in encoder(network_input(rgb[np.newaxis])))
    std = np.exp(0.5 * logvar)
    assert np.abs(found.mean(axis=0) - mean).max() < 5.0 * std.max() / np.sqrt(20_000)
    np.testing.assert_allclose(found.std(axis=0), std, rtol=0.03)


def test_mean_posterior_is_the_mean(encoder: Dronet, rgb: NDArray[np.uint8]) -> None:
    with torch.inference_mode():
        mean, _ = encoder(network_input(rgb[np.newaxis]))
    np.testing.assert_allclose(MeanPosterior(encoder).sample(rgb), mean.numpy(), atol=1e-6)


def test_same_seed_same_samples_and_the_next_differ(
    encoder: Dronet, rgb: NDArray[np.uint8]
) -> None:
    config = PerceptionConfig(
        latent_dims=10,
        dropout=RATE,
        sampling="mc-dropout",
        samples=SAMPLES,
        label_scale=LabelScale(offset=(0.0,) * 4, scale=(1.0,) * 4),
    )
    first, second = (make_posterior(config, encoder, seed=3) for _ in range(2))
    sample = first.sample(rgb)
    assert (sample == second.sample(rgb)).all()
    assert (sample != first.sample(rgb)).any()


def seeded(seed: int) -> torch.Generator:
    return torch.Generator().manual_seed(seed)
