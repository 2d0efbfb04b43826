"""Weights are read once they are known to be what the configuration says."""

import dataclasses
import os
from pathlib import Path

import pytest
import torch
from safetensors.torch import load_file, save_file

from flightstack.errors import ModelError
from flightstack.models import CONFIG_FILE, WEIGHTS_FILE, ModelConfig, file_sha256
from flightstack.networks.trained import build, load_trained, networks
from flightstack.policy.config import PolicyConfig
from flightstack.tables import table_text
from tests.unit.flightstack.exported import perception_config

CONFIG = ModelConfig(
    name="m0",
    recipe="test",
    strategy="de-mean",
    weights_sha256="",
    perception=perception_config(dropout=0.2, samples=8),
    policy=PolicyConfig(members=3, probabilistic=True),
)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A model test/m0 with weights at random, where models are looked for."""
    monkeypatch.setenv("FLIGHTSTACK_MODELS", str(tmp_path))
    folder = tmp_path / "test" / "m0"
    folder.mkdir(parents=True)
    weights = {
        prefix + key: value.contiguous()
        for prefix, network in networks(build(CONFIG)).items()
        for key, value in network.state_dict().items()
    }
    save_file(weights, folder / WEIGHTS_FILE)
    sign(folder, CONFIG)
    return folder


def sign(folder: Path, config: ModelConfig) -> None:
    sha256 = file_sha256(folder / WEIGHTS_FILE)
    (folder / CONFIG_FILE).write_text(
        table_text(dataclasses.replace(config, weights_sha256=sha256))
    )


def test_networks_have_the_weights_of_the_file_and_do_not_train(folder: Path) -> None:
    model = load_trained("test/m0")
    weights = load_file(folder / WEIGHTS_FILE)
    assert torch.equal(model.policies.dense1.weight, weights["policies.dense1.weight"])
    assert not model.encoder.training


def test_flipped_byte_is_found(folder: Path) -> None:
    data = bytearray((folder / WEIGHTS_FILE).read_bytes())
    data[-5] ^= 1
    (folder / WEIGHTS_FILE).write_bytes(data)
    with pytest.raises(ModelError, match=r"weights\.safetensors is damaged: its hash"):
        load_trained("test/m0")


def test_file_that_is_no_weights_is_one_clear_error(folder: Path) -> None:
    (folder / WEIGHTS_FILE).write_bytes(b"not weights at all")
    sign(folder, CONFIG)
    with pytest.raises(ModelError, match="cannot be read"):
        load_trained("test/m0")


def test_missing_weights_are_one_clear_error(folder: Path) -> None:
    (folder / WEIGHTS_FILE).unlink()
    with pytest.raises(ModelError, match="cannot be read"):
        load_trained("test/m0")


def test_weights_of_another_architecture_are_refused(folder: Path) -> None:
    other = dataclasses.replace(CONFIG, policy=PolicyConfig(members=5, probabilistic=True))
    sign(folder, other)
    message = r"do not fit config\.toml: policies\.dense1\.bias is \(3, 1, 256\), not \(5, 1, 256\)"
    with pytest.raises(ModelError, match=message) as caught:
        load_trained("test/m0")
    assert "\n" not in str(caught.value)


def test_unknown_parts_in_the_weights_are_refused(folder: Path) -> None:
    weights = load_file(folder / WEIGHTS_FILE) | {"autopilot.gain": torch.ones(1)}
    save_file(weights, folder / WEIGHTS_FILE)
    sign(folder, CONFIG)
    with pytest.raises(ModelError, match=r"unknown parts, such as 'autopilot\.gain'"):
        load_trained("test/m0")


def test_a_huge_model_is_refused_before_anything_is_allocated(folder: Path) -> None:
    policy = PolicyConfig(members=60000, probabilistic=True, hidden=(60000, 60000))  # 900 TB
    sign(folder, dataclasses.replace(CONFIG, policy=policy))
    with pytest.raises(ModelError, match=r"is \(3, 1, 256\), not \(60000, 1, 60000\)"):
        load_trained("test/m0")


def test_weights_of_another_kind_of_number_are_refused(folder: Path) -> None:
    weights = load_file(folder / WEIGHTS_FILE)
    weights["policies.out.bias"] = weights["policies.out.bias"].double()
    save_file(weights, folder / WEIGHTS_FILE)
    sign(folder, CONFIG)
    with pytest.raises(ModelError, match=r"policies\.out\.bias is F64, not F32"):
        load_trained("test/m0")


def test_weights_that_are_no_file_are_not_waited_for(folder: Path) -> None:
    (folder / WEIGHTS_FILE).unlink()
    os.mkfifo(folder / WEIGHTS_FILE)
    with pytest.raises(ModelError, match="cannot be read"):
        load_trained("test/m0")
