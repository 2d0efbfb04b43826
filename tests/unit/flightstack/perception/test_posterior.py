import numpy as np
import pytest
import torch

from flightstack.arrays import SmallRgb
from flightstack.networks.dronet import Dronet
from flightstack.networks.images import network_input
from flightstack.perception.encoder import Encoder
from flightstack.perception.posterior import (
    GaussianPosterior,
    McDropoutPosterior,
    MeanPosterior,
    make_posterior,
)
from tests.unit.flightstack.exported import flown_encoder, perception_config, pixels

SAMPLES, RATE = 32, 0.2


@pytest.fixture(scope="module")
def network() -> Dronet:
    """An encoder whose head is wide awake, with batch-norm statistics of its own."""
    torch.manual_seed(0)
    encoder = Dronet(latent_dims=10, dropout=RATE)
    encoder.train()
    with torch.no_grad():
        encoder.trunk(torch.rand(16, 3, 64, 64) * 2.0 - 1.0)
    return encoder.eval()


@pytest.fixture(scope="module")
def encoder(network: Dronet, tmp_path_factory: pytest.TempPathFactory) -> Encoder:
    return flown_encoder(tmp_path_factory.mktemp("encoder"), network)


@pytest.fixture
def rgb() -> SmallRgb:
    image: SmallRgb = pixels(seed=5)[0]
    return image


def drawn(seed: int) -> tuple[torch.Tensor, torch.Tensor]:
    """The masks and the noise of the first image, drawn as documented: masks first."""
    rng = np.random.default_rng(seed)
    kept = rng.random((SAMPLES, 512), dtype=np.float32) >= RATE
    noise = rng.standard_normal((SAMPLES, 10), dtype=np.float32)
    return torch.from_numpy(kept / np.float32(1.0 - RATE)), torch.from_numpy(noise)


def test_trunk_once_equals_full_passes_with_the_same_masks(
    network: Dronet, encoder: Encoder, rgb: SmallRgb
) -> None:
    rng = np.random.default_rng(7)
    found = McDropoutPosterior(encoder, rng, samples=SAMPLES, within=False).sample(rgb)
    masks, _ = drawn(7)
    images = network_input(rgb[np.newaxis])
    with torch.inference_mode():
        expected = [network.head(network.trunk(images) * mask)[0].numpy()[0] for mask in masks]
    np.testing.assert_allclose(found, np.stack(expected), atol=1e-5)
    assert found.std(axis=0).min() > 0.0  # the masks do matter


def test_pass_draws_z_from_its_own_gaussian(
    network: Dronet, encoder: Encoder, rgb: SmallRgb
) -> None:
    found = McDropoutPosterior(encoder, np.random.default_rng(7), samples=SAMPLES).sample(rgb)
    masks, noise = drawn(7)
    with torch.inference_mode():
        mean, logvar = network.head(network.trunk(network_input(rgb[np.newaxis])) * masks)
    expected = mean + noise * torch.exp(0.5 * logvar)
    np.testing.assert_allclose(found, expected.numpy(), atol=1e-5)


def test_gaussian_samples_have_the_encoders_moments(
    network: Dronet, encoder: Encoder, rgb: SmallRgb
) -> None:
    found = GaussianPosterior(encoder, np.random.default_rng(1), samples=20_000).sample(rgb)
    with torch.inference_mode():
        mean, logvar = (part.numpy()[0] for part in network(network_input(rgb[np.newaxis])))
    std = np.exp(0.5 * logvar)
    assert np.abs(found.mean(axis=0) - mean).max() < 5.0 * std.max() / np.sqrt(20_000)
    np.testing.assert_allclose(found.std(axis=0), std, rtol=0.03)


def test_mean_posterior_is_the_mean(network: Dronet, encoder: Encoder, rgb: SmallRgb) -> None:
    with torch.inference_mode():
        mean = network(network_input(rgb[np.newaxis]))[0].numpy()
    np.testing.assert_allclose(MeanPosterior(encoder).sample(rgb), mean, atol=1e-5)


def test_same_seed_same_samples_and_the_next_differ(encoder: Encoder, rgb: SmallRgb) -> None:
    config = perception_config(dropout=RATE, samples=SAMPLES)
    first, second = (make_posterior(config, encoder, seed=3) for _ in range(2))
    sample = first.sample(rgb)
    assert (sample == second.sample(rgb)).all()
    assert (sample != first.sample(rgb)).any()
