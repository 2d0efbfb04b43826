import pickle
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

from flightstack import extensions
from flightstack.companion.cli import build_parser
from flightstack.companion.pipeline import load_pipeline
from flightstack.errors import UsageError
from flightstack.records import Image
from tests.paths import DOCS

EXAMPLE = DOCS / "examples" / "cautious"
IMAGE = Image(stamp_us=0, sequence=0, rgb=np.full((64, 64, 3), 90, dtype=np.uint8))


class HalfAPilot:
    """Remembers for ever."""

    def __init__(self, **_: object) -> None:
        self.act = print


@pytest.fixture
def importable(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(EXAMPLE))
    monkeypatch.delitem(sys.modules, "cautious", raising=False)


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What an installer leaves beside the module: the entry points of the example's own file."""
    project = tomllib.loads((EXAMPLE / "pyproject.toml").read_text())["project"]
    folder = tmp_path / f"cautious-{project['version']}.dist-info"
    folder.mkdir()
    about = f"Metadata-Version: 2.1\nName: cautious\nVersion: {project['version']}\n"
    (folder / "METADATA").write_text(about)
    lines = [
        line
        for group, points in project["entry-points"].items()
        for line in (f"[{group}]", *(f"{name} = {value}" for name, value in points.items()))
    ]
    (folder / "entry_points.txt").write_text("\n".join(lines) + "\n")
    monkeypatch.syspath_prepend(str(tmp_path))


@pytest.mark.usefixtures("importable", "installed")
def test_installed_parts_are_found_by_name_and_decide() -> None:
    assert extensions.installed(extensions.STRATEGY) == ["cautious"]
    plain = load_pipeline("strong/m0").decide(IMAGE)
    brought = load_pipeline("strong/m0", "cautious", perception="steady", policy="humble")
    decision = brought.decide(IMAGE)
    assert decision.command[1:] == pytest.approx(plain.command[1:])
    assert abs(decision.command[0]) < abs(plain.command[0])
    np.testing.assert_allclose(decision.aleatoric_std, plain.aleatoric_std * np.sqrt(2.0))


@pytest.mark.usefixtures("importable")
def test_strategy_is_found_by_its_module() -> None:
    named = load_pipeline("strong/m0", "cautious:CautiousStrategy").decide(IMAGE)
    plain = load_pipeline("strong/m0").decide(IMAGE)
    assert abs(named.command[0]) < abs(plain.command[0])


@pytest.mark.usefixtures("importable")
@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("no_such:Strategy", "does not load: ModuleNotFoundError: No module named 'no_such'"),
        ("cautious:Nothing", "does not load: AttributeError: .*Nothing"),
        ("cautious:HumblePolicy", "does not load: TypeError: .*unexpected keyword"),
        ("builtins:dict", r"does not load: dict has no method decide\(\)"),
        ("mi-mod", "unknown strategy 'mi-mod': choose one of .*or bring your own"),
    ],
)
def test_what_does_not_load_is_one_clear_error(name: str, message: str) -> None:
    with pytest.raises(UsageError, match=message) as caught:
        load_pipeline("strong/m0", name)
    assert "\n" not in str(caught.value)


def test_unknown_perception_names_what_is_installed() -> None:
    with pytest.raises(UsageError, match="unknown perception 'stedy': installed are"):
        load_pipeline("strong/m0", perception="stedy")


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("cautious:CautiousStrategy", r"CautiousStrategy has no method act\(\)"),
        ("no/such.pickle", "does not load: FileNotFoundError"),
    ],
)
@pytest.mark.usefixtures("importable")
def test_what_is_no_pilot_is_one_clear_error(name: str, message: str) -> None:
    with pytest.raises(UsageError, match=message) as caught:
        extensions.make(extensions.PILOT, name, direction="cw", seed=0)
    assert "\n" not in str(caught.value)


def test_a_pilot_must_be_able_to_forget(tmp_path: Path) -> None:
    file = tmp_path / "half.pickle"
    file.write_bytes(pickle.dumps(HalfAPilot))
    with pytest.raises(UsageError, match=r"HalfAPilot has no method reset\(\)"):
        extensions.make(extensions.PILOT, str(file), direction="cw", seed=0)


def test_companion_takes_all_three() -> None:
    options = build_parser().parse_args(["--perception", "p", "--policy", "q", "--strategy", "s"])
    assert (options.perception, options.policy, options.strategy) == ("p", "q", "s")
