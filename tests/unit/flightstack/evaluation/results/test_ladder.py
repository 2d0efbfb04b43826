from dataclasses import replace

import pytest

from flightstack.evaluation.results.ladder import ladder_sections, rung_costs
from flightstack.evaluation.results.summary import summarise
from flightstack.evaluation.trials.rows import TrialRow
from tests.unit.flightstack.evaluation.made_rows import made_row

GATES = {"level2": (32, 30, 31), "fog": (8, 3, 10)}


def rows() -> list[TrialRow]:
    return [
        replace(made_row(gates - fewer, row=row, track=track), condition=rung, outcome="missed")
        for row, fewer in (("ours", 0), ("theirs", 2))
        for rung, all_gates in GATES.items()
        for track, gates in enumerate(all_gates)
    ]


def test_a_rungs_cost_is_paired_by_track() -> None:
    costs = rung_costs(rows())
    assert set(costs) == {("ours", "fog"), ("theirs", "fog")}
    cost = costs["ours", "fog"]
    assert cost.mean == pytest.approx((-24 - 27 - 21) / 3)
    assert cost.low is not None
    assert cost.high is not None
    assert -27 <= cost.low < cost.mean < cost.high <= -21


def test_without_the_rung_that_others_stand_on_nothing_is_said_of_costs() -> None:
    only_fog = [row for row in rows() if row.condition == "fog"]
    assert rung_costs(only_fog) == {}
    text = "\n".join(ladder_sections(summarise(only_fog), only_fog, {"fog": "thick"}, "Ladder"))
    assert "Gates against" not in text


def test_the_report_has_a_line_a_rung_and_a_column_a_row() -> None:
    made = rows()
    text = "\n".join(ladder_sections(summarise(made), made, {"fog": "thick"}, "Ladder"))
    assert "| rung | ours | theirs |" in text
    assert "| level2 | 31.00 [30.00, " in text
    assert "- **fog**: thick" in text
    assert "| fog | 3 missed | 3 missed |" in text
