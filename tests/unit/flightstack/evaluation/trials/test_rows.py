import math
from dataclasses import replace
from pathlib import Path

import pytest

from flightstack.errors import UsageError
from flightstack.evaluation.trials.rows import (
    by_cell,
    by_track,
    header_line,
    read_rows,
    to_line,
)
from tests.unit.flightstack.evaluation.made_rows import ONE, made_row


def test_rows_survive_the_disk(tmp_path: Path) -> None:
    path = tmp_path / "trials.csv"
    rows = [ONE, replace(made_row(3), failure='said "no", twice\nand left', direction="ccw")]
    path.write_text(header_line() + "".join(map(to_line, rows)))
    read = read_rows(path)
    assert read == [replace(row, multimodal_share=0.333333) for row in rows]
    assert [to_line(row) for row in read] == [to_line(row) for row in rows]


def test_what_is_no_number_survives_too(tmp_path: Path) -> None:
    path = tmp_path / "trials.csv"
    path.write_text(header_line() + to_line(replace(ONE, mean_speed_m_s=math.nan)))
    assert math.isnan(read_rows(path)[0].mean_speed_m_s)


def test_a_line_that_was_cut_off_is_left_out(tmp_path: Path) -> None:
    path = tmp_path / "trials.csv"
    path.write_text(header_line() + to_line(ONE) + to_line(made_row(5))[:-20])
    assert len(read_rows(path)) == 1


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "other columns"),
        ("a,b,c\n", "other columns"),
        (header_line() + "1,2,3\n", "is damaged"),
        (header_line() + to_line(ONE).replace("1000", "many"), "is damaged"),
    ],
)
def test_refuses_what_is_no_table_of_trials(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "trials.csv"
    path.write_text(text)
    with pytest.raises(UsageError, match=said):
        read_rows(path)


def test_averages_over_the_trials_of_a_track() -> None:
    rows = [
        made_row(32),
        made_row(30, trial=1),
        made_row(4, track=1001),
        made_row(1, row="m1-mean"),
    ]
    cell = by_cell(rows)["m0-mean", "level1"]
    assert by_track(cell, "gates_passed") == {1000: 31.0, 1001: 4.0}
    assert by_track(cell, "is_full") == {1000: 0.5, 1001: 0.0}
