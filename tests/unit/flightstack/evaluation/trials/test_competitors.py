from pathlib import Path

import pytest

from flightstack.errors import ModelError, UsageError
from flightstack.evaluation.trials.competitors import (
    make_competitors,
    make_users_competitor,
    model_name,
    plain_name,
)
from flightstack.evaluation.trials.experiment import Competitor

EXAMPLES = "docs/examples/cautious"


@pytest.fixture(autouse=True)
def examples(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(EXAMPLES)


@pytest.mark.parametrize(
    ("text", "name"),
    [
        ("de-mean", "de-mean"),
        ("mi/mode/lowest/near", "mi.mode.lowest.near"),
        ("all/mean/slow:0.85", "all.mean.slow.0.85"),
        ("my_package:MyPolicy", "my_package.mypolicy"),
        ("--odd  name!", "odd-name"),
    ],
)
def test_names_become_parts_of_a_rows_name(text: str, name: str) -> None:
    assert plain_name(text) == name
    Competitor(name=f"strong.m0-{name}", model="strong/m0", strategy=text)  # it is one


def test_a_model_is_named_by_its_recipe_and_its_own_name() -> None:
    assert model_name("strong/m0") == "strong.m0"
    assert model_name("/somewhere/models/strong/m0/") == "strong.m0"


def test_models_are_paired_with_strategies_or_fly_their_own() -> None:
    rows = make_competitors(["strong/m0"], ["de-mean", "mi/mean/same"])
    assert [row.name for row in rows] == ["strong.m0-de-mean", "strong.m0-mi.mean.same"]
    (own,) = make_competitors(["strong/m0"], [])
    assert own.strategy in own.name


def test_what_a_user_brings_goes_to_the_companion() -> None:
    row = make_users_competitor("strong/m0", None, perception=None, policy="cautious:HumblePolicy")
    assert row.name == "cautious.humblepolicy"
    assert row.companion_options == ("--policy=cautious:HumblePolicy",)


def test_what_cannot_fly_is_refused_before_anything_flies() -> None:
    with pytest.raises(UsageError, match="unknown strategy 'nope'"):
        make_competitors(["strong/m0"], ["nope"])
    with pytest.raises(ModelError, match="unknown model"):
        make_competitors(["nope/m9"], [])
    with pytest.raises(UsageError, match="policy 'cautious:Nobody' does not load"):
        make_users_competitor("strong/m0", None, perception=None, policy="cautious:Nobody")


def test_a_part_that_ends_python_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(tmp_path)
    (tmp_path / "leaves.py").write_text("def leave(**_):\n    raise SystemExit(3)\n")
    with pytest.raises(UsageError, match=r"leaves:leave does not load: .* SystemExit\(3\)"):
        make_users_competitor("strong/m0", None, perception=None, policy="leaves:leave")
