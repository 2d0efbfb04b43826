"""The tables of docs/architecture.md are the folders' lists, and their order is the contracts'."""

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest

from tests.paths import DOCS, ROOT

UNTOLD = {"__init__.py", "__main__.py", "__pycache__", "py.typed"}
TEXT = (DOCS / "architecture.md").read_text()
ROOMS = re.findall(r"^### `([\w/]+)/`", TEXT, re.MULTILINE)


def told(room: str) -> list[str]:
    """What a room's table names, from the roof to the cellar."""
    section = TEXT.partition(f"### `{room}/`")[2].partition("\n### ")[0].partition("\n## ")[0]
    cells = re.findall(r"^\| (`[^|]*) \|", section, re.MULTILINE)
    return [name.rstrip("/") for cell in cells for name in re.findall(r"`([^`]+)`", cell)]


def layers(room: str) -> list[str]:
    """The layers of a room's contract, from the roof to the cellar."""
    settings: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]
    package = room.replace("/", ".")
    contracts = settings["importlinter"]["contracts"]
    mine = next(c for c in contracts if c.get("containers") == [package] and c["type"] == "layers")
    found: list[str] = mine["layers"]
    return found


def test_the_big_rooms_are_told() -> None:
    assert {"flightstack", "sitl", "sitl/autopilot", "sitl/mavlink"} <= set(ROOMS)


@pytest.mark.parametrize("room", ROOMS)
def test_a_table_is_the_list_of_its_folder(room: str) -> None:
    there = {path.name for path in Path(ROOT, room).iterdir()} - UNTOLD
    assert sorted(told(room)) == sorted(there)


@pytest.mark.parametrize("room", ROOMS)
def test_a_table_goes_from_the_roof_to_the_cellar(room: str) -> None:
    height = {
        module: number
        for number, layer in enumerate(layers(room))
        for module in re.split(r" [|:] ", layer)
    }
    modules = [name.removesuffix(".py") for name in told(room)]
    heights = [height[module] for module in modules if module in height]
    assert heights == sorted(heights)
