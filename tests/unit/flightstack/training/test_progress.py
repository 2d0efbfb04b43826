"""What a training tells while it goes: time left, a table, a picture."""

import csv
from collections.abc import Iterator
from pathlib import Path

import pytest

from flightstack import libraries
from flightstack.training import progress
from flightstack.training.progress import Curves, duration_text


def ticks(*times: float) -> Iterator[float]:
    yield from times


def read(folder: Path) -> list[dict[str, str]]:
    with (folder / "curves.csv").open(newline="") as file:
        return list(csv.DictReader(file))


def test_what_is_left_follows_from_how_long_epochs_took(tmp_path: Path) -> None:
    clock = ticks(0.0, 100.0, 100.0, 220.0, 220.0, 350.0, 350.0)
    curves = Curves(tmp_path, done=0, epochs=10, clock=lambda: next(clock))
    assert curves.add(1, loss=1.0) == "15 min"  # 9 times 100 s
    assert curves.add(2, loss=0.5) == "15 min"  # 8 times the median of 100 and 120 s
    assert curves.add(3, loss=0.25) == "14 min"


def test_a_run_that_goes_on_keeps_what_was_and_drops_what_was_not_saved(tmp_path: Path) -> None:
    first = Curves(tmp_path, done=0, epochs=4)
    for epoch in (1, 2, 3):
        first.add(epoch, loss=1.0 / epoch, **({"nll": 2.0} if epoch == 2 else {}))
    again = Curves(tmp_path, done=2, epochs=4)  # killed before the third epoch's checkpoint
    again.add(3, loss=0.3)
    rows = read(tmp_path)
    assert list(rows[0]) == ["epoch", "loss", "nll", "wall_s"]
    assert [row["epoch"] for row in rows] == ["1", "2", "3"]
    assert [row["loss"] for row in rows] == ["1", "0.5", "0.3"]
    assert [row["nll"] for row in rows] == ["", "2", ""]


def test_another_training_in_the_folder_starts_its_curves_anew(tmp_path: Path) -> None:
    (tmp_path / "curves.csv").write_bytes(b"\xff what is this")
    for done in (1, 0):
        Curves(tmp_path, done=done, epochs=2).add(done + 1, loss=1.0)
        assert [row["epoch"] for row in read(tmp_path)] == [str(done + 1)]


def test_the_picture_is_there_while_it_trains(tmp_path: Path) -> None:
    Curves(tmp_path, done=0, epochs=9).add(1, loss=1.0, nll=-1.0)
    assert (tmp_path / "curves.png").read_bytes().startswith(b"\x89PNG")


def test_without_matplotlib_there_is_the_table_and_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def load(name: str, extra: str) -> None:
        raise libraries.MissingLibraryError(f"this needs {name}: pip install '[{extra}]'")

    said: list[str] = []
    monkeypatch.setattr(progress, "load_library", load)
    curves = Curves(tmp_path, done=0, epochs=2, report=said.append)
    for epoch in (1, 2):
        curves.add(epoch, loss=1.0)
    assert len(read(tmp_path)) == 2
    assert len(said) == 1
    assert "curves.csv without curves.png" in said[0]


@pytest.mark.parametrize(
    ("seconds", "text"), [(0.4, "0 s"), (89.0, "89 s"), (600.0, "10 min"), (9000.0, "2.5 h")]
)
def test_durations_are_said_as_a_person_would(seconds: float, text: str) -> None:
    assert duration_text(seconds) == text
