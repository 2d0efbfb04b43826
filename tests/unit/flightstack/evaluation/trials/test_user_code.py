"""What a user brings is known by its source."""

import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from flightstack.evaluation.trials import paper
from flightstack.evaluation.trials.experiment import Competitor, Experiment
from flightstack.evaluation.trials.user_code import code_of

GOOD = "class Good:\n    def predict(self, z):\n        return 1\n"


@pytest.fixture
def forget(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[[], None]:
    """Let Python import from the folder, and forget what it has looked up there."""
    monkeypatch.syspath_prepend(tmp_path)
    return sys.path_importer_cache.clear


def request(*options: str, strategy: str = "de-mean") -> Experiment:
    row = Competitor(name="mine", model="strong/m0", strategy=strategy, companion_options=options)
    return Experiment(
        name="benchmark", rows=(row,), conditions=(paper.level("1"),), track_seeds=(1,), trials=1
    )


def test_a_changed_line_is_other_code(tmp_path: Path, forget: Callable[[], None]) -> None:
    file = tmp_path / "mine_alone.py"
    file.write_text(GOOD)
    forget()
    mine = request("--policy=mine_alone:Good")
    before = code_of(mine)
    assert list(before) == ["mine_alone:Good"]
    assert code_of(mine) == before
    file.write_text(GOOD.replace("1", "2"))
    assert code_of(mine) != before


def test_a_pilot_counts_and_a_pickled_one_by_its_file(
    tmp_path: Path, forget: Callable[[], None]
) -> None:
    (tmp_path / "mine_alone.py").write_text(GOOD)
    file = tmp_path / "pilot.pickle"
    file.write_bytes(b"one")
    forget()
    mine = request("--pilot=mine_alone:Good", strategy="act")
    assert list(code_of(mine)) == ["mine_alone:Good"]
    pickled = request(f"--pilot={file}", strategy="act")
    before = code_of(pickled)
    file.write_bytes(b"other")
    assert code_of(pickled).keys() == before.keys() == {str(file)}
    assert code_of(pickled) != before


def test_every_module_of_a_package_counts(tmp_path: Path, forget: Callable[[], None]) -> None:
    inner = tmp_path / "mine_whole" / "inner"
    inner.mkdir(parents=True)
    for folder in (inner.parent, inner):
        (folder / "__init__.py").write_text("")
    (inner / "good.py").write_text(GOOD)
    forget()
    mine = request("--perception=mine_whole.inner.good:Good", strategy="mine_whole:Other")
    before = code_of(mine)
    assert sorted(before) == ["mine_whole.inner.good:Good", "mine_whole:Other"]
    assert len(set(before.values())) == 1
    (inner.parent / "helper.py").write_text("X = 1\n")
    assert code_of(mine) != before


def test_what_comes_along_is_not_hashed() -> None:
    assert code_of(request(strategy="mi-mode")) == {}
    assert code_of(request(strategy="all/mean/slow:0.84")) == {}
    assert code_of(request("--policy=flightstack.policy.ensemble:PolicyEnsemble")) == {}
