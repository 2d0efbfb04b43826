import json
from pathlib import Path

from flightstack.evaluation.results.summary import summarise
from flightstack.evaluation.results.writing import plain_sections, table_sections, write
from flightstack.evaluation.trials.rows import TrialRow
from tests.unit.flightstack.evaluation.made_rows import made_row

TRACKS = range(1000, 1012)
FLOWN = {"m0-mi-mode": 30, "m0-mean": 20, "m1-mean": 20}


def rows() -> list[TrialRow]:
    return [
        made_row(gates + track % 3, row=row, track=track)
        for row, gates in FLOWN.items()
        for track in TRACKS
    ]


def test_sums_up_cells_and_all_pairs() -> None:
    summary = summarise(rows())
    cell = summary.cell("m0-mi-mode", "level1")
    assert cell is not None
    assert (cell.gates.mean, cell.full.mean, cell.trials) == (31.0, 1 / 3, 12)
    assert cell.outcomes == {"finished": 4, "missed": 8}
    assert [(one.row, one.minus, one.gates.mean) for one in summary.differences] == [
        ("m0-mi-mode", "m0-mean", 10.0),
        ("m0-mi-mode", "m1-mean", 10.0),
        ("m0-mean", "m1-mean", 0.0),
    ]


def test_tells_only_the_pairs_that_were_asked_for() -> None:
    summary = summarise(rows(), [("m1-mean", "m0-mi-mode"), ("m1-mean", "not-flown")])
    assert [(one.row, one.minus) for one in summary.differences] == [("m1-mean", "m0-mi-mode")]


def test_a_row_alone_has_no_table_of_differences() -> None:
    alone = [row for row in rows() if row.row == "m0-mean"]
    heading = "## Differences on the same tracks"
    assert heading in "".join(plain_sections(summarise(rows()), "All"))
    assert heading not in "".join(plain_sections(summarise(alone), "One"))


def test_the_papers_figures_stand_beside_ours() -> None:
    text = "\n".join(table_sections(summarise(rows())))
    assert "| row | level1 | paper |" in text
    line = next(line for line in text.splitlines() if line.startswith("| m0-mi-mode |"))
    assert line.startswith("| m0-mi-mode | 31.00 [")
    assert line.endswith("| 28.88 |")
    assert "tracks 1000 to 1011" in text


def test_a_gap_is_told() -> None:
    assert "Not complete" not in "".join(plain_sections(summarise(rows()), "All"))
    assert "Not complete: 11 to 12 a cell" in "".join(plain_sections(summarise(rows()[1:]), "All"))


def test_the_same_rows_give_the_same_files(tmp_path: Path) -> None:
    texts = []
    for name in ("a", "b"):
        folder = tmp_path / name
        folder.mkdir()
        summary = summarise(rows())
        write(folder, summary, table_sections(summary))
        texts.append([(folder / file).read_bytes() for file in ("results.json", "results.md")])
    assert texts[0] == texts[1]
    told = json.loads(texts[0][0])
    assert told["cells"][0]["gates"]["mean"] == 31.0
    assert len(told["cells"][0]["survival"]["share"]) == 32
