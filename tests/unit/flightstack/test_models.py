import dataclasses
import os
from pathlib import Path

import numpy as np
import pytest
import torch
from safetensors.torch import load_file, save_file

from flightstack import models
from flightstack.companion.pipeline import load_pipeline
from flightstack.errors import ModelError, UsageError
from flightstack.models import CONFIG_FILE, WEIGHTS_FILE, ModelConfig, file_sha256
from flightstack.perception.config import PerceptionConfig
from flightstack.perception.labels import LabelScale
from flightstack.policy.config import PolicyConfig
from flightstack.records import Image
from flightstack.tables import table_text

CONFIG = ModelConfig(
    name="m0",
    recipe="test",
    strategy="de-mean",
    weights_sha256="",
    perception=PerceptionConfig(
        latent_dims=10,
        dropout=0.2,
        sampling="mc-dropout",
        samples=8,
        label_scale=LabelScale(offset=(1.0, 0.0, 0.0, 0.0), scale=(1.0, 0.5, 0.5, 0.5)),
    ),
    policy=PolicyConfig(members=3, probabilistic=True),
)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A model test/m0 with weights at random, where models are looked for."""
    monkeypatch.setenv("FLIGHTSTACK_MODELS", str(tmp_path))
    folder = tmp_path / "test" / "m0"
    write(folder, CONFIG)
    return folder


def write(folder: Path, config: ModelConfig) -> None:
    folder.mkdir(parents=True)
    torch.manual_seed(0)
    weights = {
        prefix + key: value.contiguous()
        for prefix, network in models.networks(models.build(config)).items()
        for key, value in network.state_dict().items()
    }
    save_file(weights, folder / WEIGHTS_FILE)
    sign(folder, config)


def sign(folder: Path, config: ModelConfig) -> None:
    sha256 = file_sha256(folder / WEIGHTS_FILE)
    (folder / CONFIG_FILE).write_text(
        table_text(dataclasses.replace(config, weights_sha256=sha256))
    )


def make_image(seed: int, size: int = 64) -> Image:
    rgb = np.random.default_rng(seed).integers(0, 256, (size, size, 3), dtype=np.uint8)
    return Image(stamp_us=seed * 50_000, sequence=seed, rgb=rgb)


def test_model_is_loaded_with_the_configuration_it_was_written_with(folder: Path) -> None:
    model = models.load("test/m0")
    assert dataclasses.replace(model.config, weights_sha256="") == CONFIG
    weights = load_file(folder / WEIGHTS_FILE)
    assert torch.equal(model.policies.dense1.weight, weights["policies.dense1.weight"])
    assert not model.encoder.training


def test_model_is_found_by_the_path_of_its_folder(folder: Path) -> None:
    assert models.load(str(folder)).config.name == "m0"


@pytest.mark.usefixtures("folder")
def test_unknown_model_lists_the_known_ones() -> None:
    with pytest.raises(ModelError, match="unknown model 'test/m9': known are test/m0"):
        models.load("test/m9")


def test_flipped_byte_is_found(folder: Path) -> None:
    data = bytearray((folder / WEIGHTS_FILE).read_bytes())
    data[-5] ^= 1
    (folder / WEIGHTS_FILE).write_bytes(data)
    with pytest.raises(ModelError, match=r"weights\.safetensors is damaged: its hash"):
        models.load("test/m0")


def test_file_that_is_no_weights_is_one_clear_error(folder: Path) -> None:
    (folder / WEIGHTS_FILE).write_bytes(b"not weights at all")
    sign(folder, CONFIG)
    with pytest.raises(ModelError, match="cannot be read"):
        models.load("test/m0")


def test_missing_weights_are_one_clear_error(folder: Path) -> None:
    (folder / WEIGHTS_FILE).unlink()
    with pytest.raises(ModelError, match="cannot be read"):
        models.load("test/m0")


def test_weights_of_another_architecture_are_refused(folder: Path) -> None:
    other = dataclasses.replace(CONFIG, policy=PolicyConfig(members=5, probabilistic=True))
    sign(folder, other)
    message = r"do not fit config\.toml: policies\.dense1\.bias is \(3, 1, 256\), not \(5, 1, 256\)"
    with pytest.raises(ModelError, match=message) as caught:
        models.load("test/m0")
    assert "\n" not in str(caught.value)


def test_unknown_parts_in_the_weights_are_refused(folder: Path) -> None:
    weights = load_file(folder / WEIGHTS_FILE) | {"autopilot.gain": torch.ones(1)}
    save_file(weights, folder / WEIGHTS_FILE)
    sign(folder, CONFIG)
    with pytest.raises(ModelError, match=r"unknown parts, such as 'autopilot\.gain'"):
        models.load("test/m0")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("samples = 8", "samples = 8\nsample = 9", "perception: unknown key 'sample'"),
        ("samples = 8", "", "perception: 'samples' is missing"),
        ("samples = 8", 'samples = "8"', "perception.samples: expected int, got '8'"),
        ('"mc-dropout"', '"mcd"', "perception.sampling: expected one of 'mc-dropout'"),
        ("dropout = 0.2", "dropout = 0.0", "'mc-dropout' needs dropout above 0"),
        ('name = "m0"', "name = ", r"config\.toml: .*[Ii]nvalid value"),
        ('name = "m0"', f"name = {'[' * 5000}", r"config\.toml: not TOML"),
        ('name = "m0"', f"name = {'9' * 5000}", r"config\.toml: not TOML"),
        ("dropout = 0.2", f"dropout = {'9' * 400}", "perception.dropout: expected float"),
        ('"de-mean"', '"m.evil:Go"', "'m.evil:Go' is not flightstack's own: .* by --strategy"),
        ('"de-mean"', '"os/path/join"', "'os/path/join' is not flightstack's own"),
        ("members = 3", "members = 99999999999999", "a size of 99999999999999: 65536 is"),
        ("hidden = [256, 64]", "hidden = [256, 70000]", "a size of 70000"),
        ("samples = 8", "samples = 999999999", "2999999997 actions an image"),
    ],
)
def test_configuration_that_is_wrong_is_one_clear_error(
    folder: Path, old: str, new: str, message: str
) -> None:
    path = folder / CONFIG_FILE
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(ModelError, match=message):
        models.load("test/m0")


def test_a_model_cannot_have_code_run(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(folder))
    (folder / "evil.py").write_text(f"open({str(folder / 'ran')!r}, 'w').close()\n")
    sign(folder, CONFIG)
    path = folder / CONFIG_FILE
    path.write_text(path.read_text().replace('"de-mean"', '"evil:Go"'))
    with pytest.raises(ModelError, match=r"^.*config\.toml: strategy 'evil:Go'"):
        load_pipeline(str(folder))
    assert not (folder / "ran").exists()


def test_a_huge_model_is_refused_before_anything_is_allocated(folder: Path) -> None:
    policy = PolicyConfig(members=60000, probabilistic=True, hidden=(60000, 60000))  # 900 TB
    sign(folder, dataclasses.replace(CONFIG, policy=policy))
    with pytest.raises(ModelError, match=r"is \(3, 1, 256\), not \(60000, 1, 60000\)"):
        models.load("test/m0")


def test_weights_of_another_kind_of_number_are_refused(folder: Path) -> None:
    weights = load_file(folder / WEIGHTS_FILE)
    weights["policies.out.bias"] = weights["policies.out.bias"].double()
    save_file(weights, folder / WEIGHTS_FILE)
    sign(folder, CONFIG)
    with pytest.raises(ModelError, match=r"policies\.out\.bias is F64, not F32"):
        models.load("test/m0")


def test_weights_that_are_no_file_are_not_waited_for(folder: Path) -> None:
    (folder / WEIGHTS_FILE).unlink()
    os.mkfifo(folder / WEIGHTS_FILE)
    with pytest.raises(ModelError, match="cannot be read"):
        models.load("test/m0")


@pytest.mark.usefixtures("folder")
def test_decisions_are_a_function_of_images_and_seed() -> None:
    images = [make_image(k) for k in range(3)]
    first, again, other = (load_pipeline("test/m0", seed=seed) for seed in (1, 1, 2))
    commands = [[pipeline.decide(f).command for f in images] for pipeline in (first, again, other)]
    np.testing.assert_array_equal(commands[0], commands[1])
    assert (np.array(commands[0]) != np.array(commands[2])).any()


@pytest.mark.usefixtures("folder")
def test_decision_carries_every_members_score() -> None:
    decision = load_pipeline("test/m0", "mi-mode").decide(make_image(0))
    assert decision.score.shape == (3, 4)
    assert (decision.member == decision.score.argmin(axis=0)).all()


@pytest.mark.usefixtures("folder")
def test_images_of_any_size_are_taken() -> None:
    decision = load_pipeline("test/m0").decide(make_image(0, size=240))
    assert np.isfinite(decision.command).all()


def test_commands_stay_inside_the_velocity_range(folder: Path) -> None:
    weights = load_file(folder / WEIGHTS_FILE)
    weights["policies.out.bias"][..., :4] = 50.0
    save_file(weights, folder / WEIGHTS_FILE)
    sign(folder, CONFIG)
    assert load_pipeline("test/m0").decide(make_image(0)).command.tolist() == [7.0, 3.0, 3.0, 1.0]


@pytest.mark.usefixtures("folder")
def test_unknown_strategy_is_a_usage_error() -> None:
    with pytest.raises(UsageError, match="unknown strategy 'best'"):
        load_pipeline("test/m0", "best")
