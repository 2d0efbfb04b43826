import dataclasses
import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from flightstack import models
from flightstack.companion.pipeline import load_pipeline
from flightstack.errors import UsageError
from flightstack.networks.dronet import Dronet
from flightstack.networks.images import network_input
from flightstack.records import Image
from flightstack.training import presets
from flightstack.training.commands import all_models
from flightstack.training.data.dataset import Dataset, read_dataset
from flightstack.training.data.generation import generate_control
from flightstack.training.models.assemble import write_model
from flightstack.training.models.catalogue import read_catalogue
from flightstack.training.models.recalibrate import Labelled, measure, recalibrate
from flightstack.training.perception.trainer import PerceptionRun
from flightstack.training.policy.metrics import PolicyMetrics
from flightstack.training.policy.trainer import train_policy
from flightstack.training.presets import PolicySettings
from flightstack.training.recipe import Dagger, Recipe
from flightstack.training.runs import read_run

STRONG = Recipe.load("strong")
TEST = dataclasses.replace(STRONG, name="test")


@pytest.fixture(scope="module")
def policy_folder(
    control_data: Dataset, encoder: Dronet, tmp_path_factory: pytest.TempPathFactory
) -> Path:
    folder = tmp_path_factory.mktemp("runs") / "policy-mcd-ensemble-0"
    settings = PolicySettings(members=5, probabilistic=True, epochs=20, batch=32)
    device = torch.device("cpu")
    train_policy(
        control_data,
        encoder,
        settings,
        folder,
        perception="x",
        device=device,
        report=lambda _: None,
    )
    return folder


@pytest.fixture
def folder(perception_run: PerceptionRun, policy_folder: Path, tmp_path: Path) -> Path:
    folder = tmp_path / "test" / "m0"
    write_model(
        folder,
        read_catalogue()["m0"],
        read_run(perception_run.folder),
        read_run(policy_folder),
        recipe=TEST,
        preset="quick",
    )
    return folder


def test_written_model_flies_on_the_trained_weights(
    folder: Path, perception_run: PerceptionRun, control_data: Dataset
) -> None:
    loaded = models.load(str(folder))
    assert loaded.config.perception.label_scale == perception_run.scale
    rgb = control_data.images[:1]
    with torch.inference_mode():
        expected = perception_run.model.encoder(network_input(rgb))[0].numpy()
    np.testing.assert_allclose(loaded.encoder.moments(rgb[0])[0], expected, atol=1e-4, rtol=1e-4)
    pipeline = load_pipeline(str(folder))
    at = control_data.splits["validation"][:40]
    pixels = control_data.images[at]
    images = [Image(stamp_us=k, sequence=k, rgb=rgb) for k, rgb in enumerate(pixels)]
    commands = np.array([pipeline.decide(image).command for image in images])
    error = np.abs(commands - control_data.labels[at]).mean(axis=0)
    constant = np.abs(control_data.labels[at] - control_data.labels[at].mean(axis=0)).mean(axis=0)
    assert (error < 0.7 * constant).all()


def test_card_tells_seed_data_and_figures(folder: Path) -> None:
    card = (folder / "README.md").read_text()
    assert card.startswith("---\nlicense: bsd-3-clause\n")
    assert "# test/m0" in card
    assert "| encoder seed | 0 |" in card
    assert "| control data, sha256 | `synthetic` |" in card
    assert "| yaw_rate |" in card


def test_recalibration_keeps_the_weights_and_flies(folder: Path, control_data: Dataset) -> None:
    before = models.read_config(folder / models.CONFIG_FILE)
    recalibrate(str(folder), Labelled.held_out(control_data), seed=0, report=lambda _: None)
    after = models.read_config(folder / models.CONFIG_FILE)
    assert after.weights_sha256 == before.weights_sha256
    assert all(0 <= member < 5 for member in after.policy.best_member)
    assert after.policy.variance_factor == pytest.approx(before.policy.variance_factor, rel=0.5)
    assert "redicted variances are" in (folder / "README.md").read_text()
    image = Image(stamp_us=0, sequence=0, rgb=control_data.images[:1][0])
    decision = load_pipeline(str(folder), "best/mean/same").decide(image)
    assert tuple(decision.member) == after.policy.best_member


def test_a_model_is_measured_as_it_flies(folder: Path, control_data: Dataset) -> None:
    """With fewer latent samples its mean is worse; with none drawn there is no spread of them."""
    model, validation = models.load(str(folder)), Labelled.held_out(control_data)

    def metrics(**perception: Any) -> PolicyMetrics:
        changed = dataclasses.replace(model.config.perception, **perception)
        config = dataclasses.replace(model.config, perception=changed)
        return measure(dataclasses.replace(model, config=config), validation, seed=0)

    many, one = metrics(), metrics(samples=1)
    assert sum(one.rmse) > sum(many.rmse)
    assert min(many.latent_std) > 0.0
    assert one.latent_std == metrics(sampling="mean", samples=1).latent_std == (0.0,) * 4


@pytest.fixture
def plan(tmp_path: Path) -> all_models.Plan:
    return all_models.Plan(
        recipe=STRONG,
        preset="quick",
        seed=0,
        data_seed=0,
        device="none",
        data=tmp_path / "data",
        runs=tmp_path / "runs",
        models=tmp_path / "models",
        only=("m0",),
    )


def test_policies_learn_from_a_first_models_flights_too(
    perception_run: PerceptionRun,
    policy_folder: Path,
    plan: all_models.Plan,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    learned_from = []
    monkeypatch.setattr(all_models, "_train_stack", lambda *given: learned_from.append(given[3]))
    monkeypatch.setitem(presets.IMAGES["quick"], "control", 20)
    shutil.copytree(perception_run.folder, plan.run_folder / "perception-mcd-0")
    shutil.copytree(policy_folder, plan.dagger_folder / "policy-mcd-ensemble-0")
    expert = plan.data / "strong" / "control"
    generate_control(expert, STRONG, images=20, seed=0, jobs=1, report=print)
    all_models.fly_dagger(plan, Dagger(images_share=0.5))
    all_models.train_stack(plan, "mcd", "ensemble")

    pilot = models.read_config(plan.dagger_folder / "m0" / models.CONFIG_FILE)
    alone, both = learned_from
    assert alone.sha256 == read_dataset(expert).sha256
    assert [len(both.splits[name]) for name in ("train", "validation")] == [18 + 9, 2 + 1]
    flown = both.manifest["joined"][1]
    assert flown["pilot"]["weights_sha256"] == pilot.weights_sha256
    assert flown["seed"] != both.manifest["joined"][0]["seed"]

    shutil.move(plan.runs, plan.runs.with_name("moved"))  # wherever it lies, it is the same
    moved = dataclasses.replace(plan, runs=plan.runs.with_name("moved"))
    all_models.fly_dagger(moved, Dagger(images_share=0.5))
    assert moved.flights().sha256 == both.sha256


def test_a_first_model_needs_its_encoder_whichever_models_are_asked_for(
    plan: all_models.Plan, monkeypatch: pytest.MonkeyPatch
) -> None:
    class FlownError(Exception):
        """Far enough."""

    def fly(*_: object) -> None:
        raise FlownError

    trained: list[str] = []
    monkeypatch.setattr(all_models, "PROCESSES", 1)
    monkeypatch.setattr(all_models, "make_data", lambda _: None)
    monkeypatch.setattr(all_models, "train_encoder", lambda _, encoder: trained.append(encoder))
    monkeypatch.setattr(all_models, "fly_dagger", fly)
    with pytest.raises(FlownError):
        all_models.train_all(dataclasses.replace(plan, device="cpu", only=("m1",)))
    assert trained == ["mcd", "plain"]


def test_all_calibrates_every_model_that_it_writes(
    perception_run: PerceptionRun,
    policy_folder: Path,
    plan: all_models.Plan,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    runs = tmp_path / "runs" / "strong"
    shutil.copytree(perception_run.folder, runs / "perception-mcd-0")
    shutil.copytree(policy_folder, runs / "policy-mcd-ensemble-0")
    for finished in ("make_data", "train_encoder", "fly_dagger", "train_stack"):
        monkeypatch.setattr(all_models, finished, lambda *_: None)
    monkeypatch.setitem(presets.CALIBRATION_IMAGES, "quick", 20)
    all_models.train_all(plan)
    folder = tmp_path / "models" / "strong" / "m0"
    assert json.loads((folder / "metrics.json").read_text())["policy"]["images"] == 20
    assert models.load(str(folder)).config.policy.best_member


def test_validation_flights_are_a_function_of_their_seed() -> None:
    first, again = (Labelled.flown(STRONG, images=4, seed=3) for _ in range(2))
    assert np.array_equal(first.images, again.images)
    assert np.array_equal(first.commands, again.commands)
    other = Labelled.flown(STRONG, images=4, seed=4)
    assert not np.array_equal(first.images, other.images)


def test_a_deterministic_policy_gets_the_variance_that_it_leaves_unexplained(
    perception_run: PerceptionRun, control_data: Dataset, encoder: Dronet, tmp_path: Path
) -> None:
    settings = PolicySettings(members=1, probabilistic=False, epochs=20, batch=32)
    common: dict[str, Any] = {
        "perception": "x",
        "device": torch.device("cpu"),
        "report": lambda _: None,
    }
    train_policy(control_data, encoder, settings, tmp_path / "run", **common)
    runs = read_run(perception_run.folder), read_run(tmp_path / "run")
    folder = tmp_path / "m3"
    write_model(folder, read_catalogue()["m3"], *runs, recipe=TEST, preset="quick")
    recalibrate(str(folder), Labelled.held_out(control_data), seed=0, report=lambda _: None)
    measured = json.loads((folder / "metrics.json").read_text())["policy"]
    assert max(measured["coverage_before"]) < 0.85
    assert measured["coverage"] == pytest.approx([0.9] * 4, abs=0.02)
    image = Image(stamp_us=0, sequence=0, rgb=control_data.images[:1][0])
    decision = load_pipeline(str(folder)).decide(image)
    assert decision.aleatoric_std == pytest.approx(measured["aleatoric_std"], rel=1e-4)


def test_metrics_stand_beside_the_weights(folder: Path, perception_run: PerceptionRun) -> None:
    metrics = json.loads((folder / "metrics.json").read_text())
    assert metrics["perception"]["label_mae"] == pytest.approx(perception_run.metrics.label_mae)
    assert len(metrics["policy"]["coverage"]) == 4
    assert metrics["trained"]["preset"] == "quick"


def test_image_decoder_does_not_fly(folder: Path) -> None:
    assert (folder / "weights.safetensors").stat().st_size < 2_500_000


def test_unfinished_run_is_a_clear_error(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="no finished training here"):
        read_run(tmp_path)


def test_catalogue_holds_the_papers_five_models() -> None:
    plans = read_catalogue()
    assert list(plans) == ["m0", "m1", "m2", "m3", "m4"]
    assert [plan.samples for plan in plans.values()] == [32, 32, 1, 32, 1]


def test_misspelt_catalogue_is_a_clear_error(tmp_path: Path) -> None:
    path = tmp_path / "models.toml"
    path.write_text('[m0]\nencoder = "mc"\n')
    with pytest.raises(UsageError, match=r"models\.toml: m0: 'sampling' is missing"):
        read_catalogue(path)
