import dataclasses
import os
import shutil
from pathlib import Path

import numpy as np
import onnx
import pytest
import torch
from safetensors.torch import save_file

from flightstack import models
from flightstack.companion.pipeline import load_pipeline
from flightstack.errors import ModelError, UsageError
from flightstack.models import CONFIG_FILE, WEIGHTS_FILE, FlightForm, ModelConfig, file_sha256
from flightstack.networks.export import export_model
from flightstack.networks.trained import TrainedModel, build, load_trained, networks
from flightstack.perception.config import PerceptionConfig
from flightstack.perception.encoder import ENCODER_FILE
from flightstack.perception.labels import LabelScale
from flightstack.policy.config import PolicyConfig
from flightstack.policy.networks import POLICIES_FILE
from flightstack.records import Image
from flightstack.tables import table_text
from tests.unit.flightstack.exported import pixels

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


@pytest.fixture(scope="module")
def original(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A model's folder with weights at random."""
    folder = tmp_path_factory.mktemp("models") / "m0"
    folder.mkdir()
    write(folder, build(CONFIG))
    return folder


@pytest.fixture
def folder(original: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The same, test/m0, where models are looked for."""
    monkeypatch.setenv("FLIGHTSTACK_MODELS", str(tmp_path))
    folder = tmp_path / "test" / "m0"
    shutil.copytree(original, folder)
    return folder


def write(folder: Path, model: TrainedModel) -> None:
    torch.manual_seed(0)
    weights = {
        prefix + key: value.contiguous()
        for prefix, network in networks(model).items()
        for key, value in network.state_dict().items()
    }
    save_file(weights, folder / WEIGHTS_FILE)
    export_model(folder, model, pixels())
    sign(folder, model.config)


def sign(folder: Path, config: ModelConfig) -> None:
    """Record the hashes of what lies in the folder."""
    signed = dataclasses.replace(
        config,
        weights_sha256=file_sha256(folder / WEIGHTS_FILE),
        flight=FlightForm(
            encoder_sha256=file_sha256(folder / ENCODER_FILE),
            policies_sha256=file_sha256(folder / POLICIES_FILE),
        ),
    )
    (folder / CONFIG_FILE).write_text(table_text(signed))


def make_image(seed: int, size: int = 64) -> Image:
    rgb = np.random.default_rng(seed).integers(0, 256, (size, size, 3), dtype=np.uint8)
    return Image(stamp_us=seed * 50_000, sequence=seed, rgb=rgb)


def test_model_is_loaded_with_the_configuration_it_was_written_with(folder: Path) -> None:
    found = models.load("test/m0").config
    assert dataclasses.replace(found, weights_sha256="", flight=FlightForm()) == CONFIG
    assert load_trained("test/m0").config == found == models.load(str(folder)).config


def test_model_is_found_by_the_path_of_its_folder(folder: Path) -> None:
    assert models.load(str(folder)).config.name == "m0"


@pytest.mark.usefixtures("folder")
def test_unknown_model_lists_the_known_ones() -> None:
    with pytest.raises(ModelError, match="unknown model 'test/m9': known are test/m0"):
        models.load("test/m9")


@pytest.mark.parametrize("name", [ENCODER_FILE, POLICIES_FILE])
def test_flipped_byte_is_found(folder: Path, name: str) -> None:
    data = bytearray((folder / name).read_bytes())
    data[-5] ^= 1
    (folder / name).write_bytes(data)
    with pytest.raises(ModelError, match=rf"{name} is damaged: its hash"):
        models.load("test/m0")


def test_file_that_is_no_graph_is_one_clear_error(folder: Path) -> None:
    (folder / ENCODER_FILE).write_bytes(b"not a graph at all")
    sign(folder, CONFIG)
    with pytest.raises(ModelError, match="is refused: it is no graph of ONNX") as caught:
        models.load("test/m0")
    assert "\n" not in str(caught.value)


def test_missing_graph_is_one_clear_error(folder: Path) -> None:
    (folder / POLICIES_FILE).unlink()
    with pytest.raises(ModelError, match="cannot be read: there is no such file"):
        models.load("test/m0")


def test_a_model_without_its_flight_form_says_how_to_get_it(folder: Path) -> None:
    (folder / CONFIG_FILE).write_text(table_text(CONFIG))
    with pytest.raises(ModelError, match=r"no flight form yet: '.*training export test/m0' makes"):
        models.load("test/m0")


def test_graph_of_another_architecture_is_refused(folder: Path) -> None:
    other = dataclasses.replace(CONFIG, policy=PolicyConfig(members=5, probabilistic=True))
    sign(folder, other)
    message = r"policies\.onnx does not fit config\.toml: mean is \(3, any, 4\), not \(5, any, 4\)"
    with pytest.raises(ModelError, match=message):
        models.load("test/m0")


def test_graph_that_answers_something_else_is_refused(folder: Path) -> None:
    graph = onnx.load(folder / POLICIES_FILE)
    graph.graph.output[1].name = graph.graph.node[-1].output[0] = "deviation"
    onnx.save(graph, folder / POLICIES_FILE)
    sign(folder, CONFIG)
    with pytest.raises(ModelError, match="its outputs are mean, deviation, not mean, var"):
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


def test_a_graph_that_is_no_file_is_not_waited_for(folder: Path) -> None:
    (folder / ENCODER_FILE).unlink()
    os.mkfifo(folder / ENCODER_FILE)
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
    model = load_trained("test/m0")
    with torch.no_grad():
        model.policies.out.bias[..., :4] = 50.0
    write(folder, model)
    assert load_pipeline("test/m0").decide(make_image(0)).command.tolist() == [7.0, 3.0, 3.0, 1.0]


@pytest.mark.usefixtures("folder")
def test_unknown_strategy_is_a_usage_error() -> None:
    with pytest.raises(UsageError, match="unknown strategy 'best'"):
        load_pipeline("test/m0", "best")
