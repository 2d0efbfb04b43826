"""A library that is not installed: one line that names it and the extra that brings it."""

import tomllib

import pytest

from flightstack.libraries import MissingLibraryError, load_library, load_pyplot
from tests.paths import ROOT


def test_returns_the_module_that_was_asked_for() -> None:
    assert load_library("email.message", "logs").Message


def test_names_the_library_and_its_extra() -> None:
    with pytest.raises(MissingLibraryError) as caught:
        load_library("nothing_like_it.at_all", "evaluation")
    assert str(caught.value) == "this needs nothing_like_it: pip install 'flightstack[evaluation]'"
    assert caught.value.exit_code == 2


def test_both_extras_that_draw_bring_matplotlib() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert all("matplotlib" in project["optional-dependencies"][e] for e in ("logs", "evaluation"))
    assert load_pyplot("logs").get_backend().lower() == "agg"
