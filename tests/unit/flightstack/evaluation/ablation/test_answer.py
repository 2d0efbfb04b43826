from dataclasses import replace

import pytest

from flightstack.evaluation.ablation.answer import answer
from flightstack.evaluation.ablation.design import FACTORS, PAPERS, VX, cube, factorial
from flightstack.evaluation.ablation.pace import Control
from flightstack.evaluation.ablation.report import ablation_sections
from flightstack.evaluation.results.summary import summarise
from flightstack.evaluation.trials.rows import TrialRow
from tests.unit.flightstack.evaluation.made_rows import made_row

TRACKS = range(1000, 1010)
Controls = dict[str, Control]


@pytest.fixture
def controls() -> Controls:
    """Every strategy that slows down flies as fast as the mean at nine tenths."""
    return {
        point.strategy: Control(
            strategy=point.strategy,
            pace_m_s=1.5,
            factor=0.9 if point.vx == PAPERS[VX] else 1.0,
        )
        for point in cube()
    }


@pytest.fixture
def rows(controls: Controls) -> list[TrialRow]:
    """Slowing down, in whatever way, gives four gates; nothing else gives any."""
    strategies = {p.strategy: 4 * (p.vx == PAPERS[VX]) for p in cube()}
    strategies |= {controls["mi-mode"].rule: 4}
    return [
        replace(
            made_row(20 + more + track % 3, row=name.replace("/", "."), track=track), strategy=name
        )
        for name, more in strategies.items()
        for track in TRACKS
    ]


def test_a_slow_down_is_told_from_what_it_is_wrapped_in(
    rows: list[TrialRow], controls: Controls
) -> None:
    (found,) = answer(rows, cube(), controls).answers
    shares = [found.shares["gates_passed"][factor].mean for factor in FACTORS]
    assert shares == pytest.approx([0.0, 0.0, 4.0])
    assert found.whole.gates.mean == pytest.approx(4.0)
    assert found.pace_alone.gates.mean == pytest.approx(4.0)
    (left,) = (one for one in found.controls if one.strategy == "mi-mode")
    assert left.minus == "all/mean/slow:0.90"
    assert left.gates.mean == pytest.approx(0.0)


def test_a_condition_that_is_not_complete_has_no_answer(
    rows: list[TrialRow], controls: Controls
) -> None:
    missing = [row for row in rows if row.strategy != "mi/mean/same"]
    assert answer(missing, cube(), controls).answers == ()


def test_the_report_answers_in_one_table(rows: list[TrialRow], controls: Controls) -> None:
    found = answer(rows, cube(), controls)
    text = "\n".join(ablation_sections(summarise(rows, []), found, "strong/m0"))
    assert "| **mi-mode - de-mean** | +4.00" in text
    assert "| of that: slow-down | +4.00" in text
    assert "| of that: member choice | +0.00" in text
    assert "| mi-mode - that | +0.00" in text
    assert "| mi-mode | 1.500 | 0.90 |" in text


def test_all_combinations_tell_each_levels_effect_too() -> None:
    points = factorial(with_best=False)
    control = Control(strategy="", pace_m_s=1.5, factor=1.0)
    controls = {p.strategy: replace(control, strategy=p.strategy) for p in points}
    rows = [
        replace(
            made_row(20 + 3 * (p.vx != "same"), row=p.strategy.replace("/", "."), track=track),
            strategy=p.strategy,
        )
        for p in points
        for track in TRACKS[:3]
    ]
    found = answer(rows, points, controls)
    main = found.answers[0].main["gates_passed"]
    assert main["slow-down: lowest-mode"].mean == pytest.approx(3.0)
    assert main["member choice: random"].mean == pytest.approx(0.0)
    text = "\n".join(ablation_sections(summarise(rows, []), found, "strong/m0"))
    assert "| level1 | slow-down: lowest | +3.00" in text
