"""All pictures of an experiment, from its rows and traces alone."""

import sys
from pathlib import Path

import numpy as np
import pytest

from flightstack.errors import UsageError
from flightstack.evaluation.flights.trace import Trace
from flightstack.evaluation.pictures.gallery import draw_all, find_ways
from flightstack.evaluation.pictures.ladder import draw_ladder
from flightstack.evaluation.results.summary import summarise
from tests.unit.flightstack.evaluation.made_rows import made_row

ROWS = [
    made_row(gates + track % 4, row=row, track=track)
    for row, gates in (("m0-mi-mode", 20), ("m0-mean", 12))
    for track in range(1000, 1004)
]


def made_folder(folder: Path) -> Path:
    (folder / "traces").mkdir(parents=True)
    for row in ROWS[1:]:  # the first one's is lost
        name = "-".join(map(str, row.key))
        Trace(
            time_s=np.arange(50) / 20,
            position_ned=np.linspace((0, 0, -3), (20, row.gates_passed, -3), 50),
            uncertainty=np.linspace(0.1, 0.5, 50),
            gates=np.zeros((0, 4)),
        ).save(folder / "traces" / f"{name}.npz")
    return folder


def test_every_picture_is_written_and_named_and_always_the_same(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    drawn = []
    for name in ("one", "other"):
        out = made_folder(tmp_path / name)
        section = draw_all(out, summarise(ROWS), ROWS, {"ladder": draw_ladder})
        files = sorted((out / "pictures").iterdir())
        drawn.append([file.read_bytes() for file in files])
        assert all(f"(pictures/{file.name})" in section for file in files)
        names = ["birds-eye.png", "differences.png", "ladder.png", "survival.png"]
        assert [file.name for file in files] == names
    assert drawn[0] == drawn[1]
    assert all(picture.startswith(b"\x89PNG") for picture in drawn[0])


def test_a_lost_trace_is_left_out(tmp_path: Path) -> None:
    ways = find_ways(made_folder(tmp_path / "out") / "traces", ROWS)
    assert [len(own) for own in ways.values()] == [3, 4]
    assert list(ways) == [("m0-mi-mode", "level1"), ("m0-mean", "level1")]


def test_without_matplotlib_it_says_what_to_install(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
    with pytest.raises(UsageError, match="pip install"):
        draw_all(tmp_path, summarise(ROWS), ROWS, {})
