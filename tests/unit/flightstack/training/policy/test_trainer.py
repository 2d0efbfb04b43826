import dataclasses
from pathlib import Path

import numpy as np
import pytest
import torch

from flightstack.errors import UsageError
from flightstack.networks.dronet import Dronet
from flightstack.training.data.dataset import Dataset
from flightstack.training.errors import TrainingError
from flightstack.training.models.assemble import policy_config
from flightstack.training.perception.latents import LatentSource
from flightstack.training.policy.trainer import PolicyRun, train_policy
from flightstack.training.presets import PolicySettings
from flightstack.training.runs import read_run

CPU = torch.device("cpu")
SETTINGS = PolicySettings(members=3, probabilistic=True, epochs=30, batch=32)


def train(
    data: Dataset, encoder: Dronet, folder: Path, settings: PolicySettings = SETTINGS
) -> PolicyRun:
    return train_policy(
        data, encoder, settings, folder, perception="encoder", device=CPU, report=lambda _: None
    )


def test_policies_beat_the_constant_and_cover_their_labels(
    control_data: Dataset, encoder: Dronet, tmp_path: Path
) -> None:
    metrics = train(control_data, encoder, tmp_path).metrics
    ratios = np.array(metrics.rmse) / np.array(metrics.constant_rmse)
    assert ratios.max() < 0.7
    assert min(metrics.coverage) > 0.75  # of nominally 0.9, on 160 images
    assert all(np.isfinite(metrics.nll))


def test_members_differ_and_are_told_apart_from_latents(
    control_data: Dataset, encoder: Dronet, tmp_path: Path
) -> None:
    metrics = train(control_data, encoder, tmp_path).metrics
    assert min(metrics.policy_std) > 0.0
    assert min(metrics.latent_std) > 0.0


def test_deterministic_policy_learns_the_mean(
    control_data: Dataset, encoder: Dronet, tmp_path: Path
) -> None:
    settings = dataclasses.replace(SETTINGS, members=1, probabilistic=False)
    metrics = train(control_data, encoder, tmp_path, settings).metrics
    assert (np.array(metrics.rmse) < 0.7 * np.array(metrics.constant_rmse)).all()


def test_mixture_heads_learn_and_are_read_back(
    control_data: Dataset, encoder: Dronet, tmp_path: Path
) -> None:
    settings = dataclasses.replace(SETTINGS, mixture=3)
    run = train(control_data, encoder, tmp_path, settings)
    assert (np.array(run.metrics.rmse) < 0.7 * np.array(run.metrics.constant_rmse)).all()
    assert policy_config(read_run(tmp_path).summary) == dataclasses.replace(
        run.config,
        variance_factor=run.metrics.variance_factor,
        best_member=run.metrics.best_member,
    )


@pytest.mark.parametrize("bootstrap", [False, True])
def test_interrupted_training_resumes_to_the_same_result(
    control_data: Dataset, encoder: Dronet, tmp_path: Path, *, bootstrap: bool
) -> None:
    settings = dataclasses.replace(SETTINGS, epochs=24, bootstrap=bootstrap)

    def stop_at_20(line: str) -> None:
        if "epoch 20/" in line:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        train_policy(
            control_data,
            encoder,
            settings,
            tmp_path / "cut",
            perception="encoder",
            device=CPU,
            report=stop_at_20,
        )
    for name in ("cut", "whole"):
        train(control_data, encoder, tmp_path / name, settings)
    assert read_run(tmp_path / "cut").sha256 == read_run(tmp_path / "whole").sha256


def test_nan_in_the_loss_is_a_clear_error(
    control_data: Dataset, encoder: Dronet, tmp_path: Path
) -> None:
    settings = dataclasses.replace(SETTINGS, learning_rate=1e30)
    with pytest.raises(TrainingError, match=r"the loss is (nan|inf) in epoch \d+: lower"):
        train(control_data, encoder, tmp_path, settings)
    assert not (tmp_path / "policy.safetensors").exists()


def test_other_encoder_is_refused(control_data: Dataset, encoder: Dronet, tmp_path: Path) -> None:
    settings = dataclasses.replace(SETTINGS, epochs=1, learning_rate=0.0)
    with pytest.raises(TrainingError, match="was not learned"):
        train(control_data, encoder, tmp_path, settings)
    with pytest.raises(UsageError, match="written with another perception"):
        train_policy(
            control_data,
            encoder,
            settings,
            tmp_path,
            perception="another",
            device=CPU,
            report=lambda _: None,
        )


def test_perception_data_is_refused(
    perception_data: Dataset, encoder: Dronet, tmp_path: Path
) -> None:
    with pytest.raises(UsageError, match="control data needs"):
        train(perception_data, encoder, tmp_path)


def test_latents_of_a_dataset_follow_the_encoders_posterior(
    control_data: Dataset, encoder: Dronet
) -> None:
    source = LatentSource(encoder, control_data.images, CPU)
    generator = torch.Generator().manual_seed(0)
    draws = torch.stack([source.draw(generator) for _ in range(400)])  # (D, K, Z)
    with torch.inference_mode():
        mean, logvar = encoder.head(source.features[:1].expand(20_000, -1))
        mask = torch.rand(20_000, 512, generator=generator) >= encoder.dropout
        masked, logvar = encoder.head(source.features[:1] * mask / (1.0 - encoder.dropout))
    expected_var = masked.var(dim=0) + logvar.exp().mean(dim=0)
    torch.testing.assert_close(draws[:, 0].var(dim=0), expected_var, rtol=0.4, atol=0.0)
    assert float((draws[:, 0].mean(dim=0) - masked.mean(dim=0)).abs().max()) < 0.3
    assert mean.shape == masked.shape
