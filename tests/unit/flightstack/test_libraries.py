"""A library that is not installed: one line that names it and the command that brings it."""

import importlib.metadata
import json
import tomllib
from pathlib import Path
from typing import Any

import pytest

from flightstack import libraries
from flightstack.libraries import MissingLibraryError, load_library, load_pyplot, require
from tests.paths import ROOT


def test_returns_the_module_that_was_asked_for() -> None:
    assert load_library("email.message", "logs").Message


def test_names_the_library_and_how_this_checkout_gets_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.executable", "/somewhere/python")
    with pytest.raises(MissingLibraryError) as caught:
        load_library("nothing_like_it.at_all", "evaluation")
    assert str(caught.value) == (
        "this needs nothing_like_it: /somewhere/python -m pip install "
        f"--constraint {ROOT}/constraints.txt --editable '{ROOT}[evaluation]'"
    )
    assert caught.value.exit_code == 2


@pytest.mark.parametrize(
    ("recorded", "origin"),
    [
        (json.dumps({"url": "file:///srv/flightstack-1.whl"}), "file:///srv/flightstack-1"),
        (None, "<the wheel's path or address>"),
        ("no JSON", "<the wheel's path or address>"),
    ],
)
def test_names_where_a_wheel_came_from(
    recorded: str | None, origin: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    class Installed:
        def read_text(self, _: str) -> str | None:
            return recorded

    def installed(_: str) -> Any:
        return Installed()

    monkeypatch.setattr(libraries, "ROOT", tmp_path)
    monkeypatch.setattr(libraries, "distribution", installed)
    with pytest.raises(MissingLibraryError, match=rf"pip install 'flightstack\[sim\] @ {origin}"):
        require("sim", "json", "nothing_like_it")


def test_says_so_of_a_package_that_is_not_installed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def missing(_: str) -> Any:
        raise importlib.metadata.PackageNotFoundError

    monkeypatch.setattr(libraries, "ROOT", tmp_path)
    monkeypatch.setattr(libraries, "distribution", missing)
    assert "<the wheel's path or address>" in libraries.install_command("logs")


def test_both_extras_that_draw_bring_matplotlib() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert all("matplotlib" in project["optional-dependencies"][e] for e in ("logs", "evaluation"))
    assert load_pyplot("logs").get_backend().lower() == "agg"
