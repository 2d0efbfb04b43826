"""What stands in a picture is what the statistics say, at its place and with its name."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from flightstack.evaluation.ablation.answer import Ablation, Comparison, ConditionAnswer
from flightstack.evaluation.ablation.design import FACTORS
from flightstack.evaluation.ablation.picture import draw_ablation
from flightstack.evaluation.pictures.differences import draw_differences
from flightstack.evaluation.pictures.ladder import draw_ladder
from flightstack.evaluation.pictures.survival import draw_survival
from flightstack.evaluation.results.statistics import MeanEstimate
from flightstack.evaluation.results.summary import ExperimentSummary, summarise
from tests.unit.flightstack.evaluation.made_rows import made_row

pytest.importorskip("matplotlib")

TRACKS = range(1000, 1012)
FLOWN = {"m0-mi-mode": 26, "m0-mean": 20, "m1-mean": 20}
LEVELS = {"level1": 0, "level2": -9}


@pytest.fixture(scope="module")
def summary() -> ExperimentSummary:
    rng = np.random.default_rng(1)
    return summarise(
        [
            replace(
                made_row(gates + less + int(rng.integers(0, 7)), row=row, track=track),
                condition=level,
                mean_speed_m_s=1.5 + gates / 100 + float(rng.normal()) / 20,
            )
            for row, gates in FLOWN.items()
            for level, less in LEVELS.items()
            for track in TRACKS
        ]
    )


def dots(plot: Any) -> dict[float, tuple[float, bool]]:
    """Return each dot by its height: where it stands, and whether it is filled."""
    marked = [line for line in plot.lines if line.get_marker() not in ("None", "")]
    return {
        float(line.get_ydata()[0]): (
            float(line.get_xdata()[0]),
            line.get_markerfacecolor() == line.get_color(),
        )
        for line in marked
    }


def whiskers(plot: Any) -> dict[float, tuple[float, float]]:
    """Return the ends of each interval by its height."""
    plain = [line for line in plot.lines if line.get_marker() in ("None", "")]
    pairs = [(line.get_xdata(), line.get_ydata()) for line in plain]
    return {float(y[0]): (float(x[0]), float(x[1])) for x, y in pairs if y[0] == y[1]}


def assert_drawn(plot: Any, estimates: list[MeanEstimate], factor: float = 1.0) -> None:
    for line, estimate in enumerate(estimates):
        assert estimate.low is not None
        assert estimate.high is not None
        mean, is_filled = dots(plot)[line]
        assert mean == pytest.approx(factor * estimate.mean)
        ends = (factor * estimate.low, factor * estimate.high)
        if estimate.low < estimate.high:
            assert whiskers(plot)[line] == pytest.approx(ends)
            assert is_filled == (estimate.low > 0 or estimate.high < 0)
        else:
            assert line not in whiskers(plot)
            assert not is_filled


def test_a_mean_without_an_interval_is_hollow() -> None:
    rows = [made_row(gates, row=row) for row, gates in (("m0", 9), ("m1", 4))]
    rows += [replace(row, track_seed=1001) for row in rows]  # both tracks the same: no spread
    gates, _, speed = draw_differences(summarise(rows)).axes
    assert dots(gates) == {0.0: (5.0, False)}
    assert dots(speed) == {0.0: (0.0, False)}
    assert line_names(gates) == ["m0 - m1"]


def line_names(plot: Any) -> list[str]:
    return [label.get_text() for label in plot.get_yticklabels()]


def test_survival_curves_are_the_shares_and_their_bands(summary: ExperimentSummary) -> None:
    figure = draw_survival(summary)
    assert [plot.get_title(loc="left") for plot in figure.axes] == list(LEVELS)
    for plot in figure.axes:
        curves = {line.get_label(): line for line in plot.lines}
        assert list(curves) == list(FLOWN)
        for place, (row, line) in enumerate(curves.items()):
            cell = summary.cell(row, plot.get_title(loc="left"))
            assert cell is not None
            assert line.get_xdata().tolist() == list(range(33))
            assert line.get_ydata().tolist() == [1.0, *cell.survival.share]
            band = plot.collections[place].get_paths()[0].vertices
            for gate in (1, 12, 25):  # the band reaches back from each gate to the one before
                heights = band[np.isclose(band[:, 0], gate), 1]
                assert cell.survival.low[gate - 1] in heights
                assert cell.survival.high[gate - 1] in heights
    assert [text.get_text() for text in figure.legends[0].get_texts()] == list(FLOWN)
    assert len({line.get_color() for line in figure.axes[0].lines}) == len(FLOWN)


def test_panels_without_a_condition_stay_empty() -> None:
    rows = [replace(made_row(9), condition=name) for name in ("a", "b", "c", "d")]
    plots = draw_survival(summarise(rows)).axes
    assert [plot.axison for plot in plots] == [True] * 4 + [False] * 2


def test_differences_stand_in_order_with_their_intervals(summary: ExperimentSummary) -> None:
    gates, full, speed = draw_differences(summary).axes
    told = summary.differences
    assert line_names(gates) == [f"{d.row} - {d.minus}  ({d.condition})" for d in told]
    assert_drawn(gates, [one.gates for one in told])
    assert_drawn(full, [one.full for one in told], 100.0)
    assert_drawn(speed, [one.speed_m_s for one in told])
    assert gates.get_ylim()[0] > gates.get_ylim()[1], "the first line is on top"
    assert {is_filled for _, is_filled in dots(gates).values()} == {True, False}


def test_a_ladder_has_every_row_on_every_rung(summary: ExperimentSummary) -> None:
    figure = draw_ladder(summary)
    plot = figure.axes[0]
    assert line_names(plot) == list(LEVELS)
    for rung, level in enumerate(LEVELS):
        heights = sorted(at for at in dots(plot) if round(at) == rung)
        assert len(heights) == len(FLOWN)
        for at, row in zip(heights, FLOWN, strict=True):
            cell = summary.cell(row, level)
            assert cell is not None
            assert dots(plot)[at][0] == pytest.approx(cell.gates.mean)
            assert whiskers(plot)[at] == (cell.gates.low, cell.gates.high)
    assert [text.get_text() for text in figure.legends[0].get_texts()] == list(FLOWN)


def made_estimate(mean: float, half: float) -> MeanEstimate:
    return MeanEstimate(mean=mean, low=mean - half, high=mean + half, tracks=9, method="bca")


def test_an_ablation_shows_the_whole_its_parts_and_the_slow_down() -> None:
    def against(minus: str, gates: MeanEstimate) -> Comparison:
        other = made_estimate(0, 1)
        return Comparison(strategy="mi-mode", minus=minus, gates=gates, full=other, speed_m_s=other)

    parts = [made_estimate(0.5, 1), made_estimate(1, 0.5), made_estimate(3, 1)]
    shares = dict(zip(FACTORS, parts, strict=True))
    whole, alone, left = made_estimate(4.5, 1), made_estimate(3.5, 1), made_estimate(1.0, 2)
    found = ConditionAnswer(
        condition="level2",
        whole=against("de-mean", whole),
        shares={"gates_passed": shares, "is_full": shares},
        added={},
        lost={},
        main={},
        pace_alone=against("de-mean", alone),
        controls=(against("all/mean/slow:0.90", left),),
    )
    (plot,) = draw_ablation(Ablation(controls=(), answers=(found,))).axes
    assert plot.get_title(loc="left") == "level2"
    assert_drawn(plot, [whole, *parts, alone, left])
    assert line_names(plot)[:2] == ["mi-mode - de-mean", f"of that: {FACTORS[0]}"]


def test_an_ablation_without_an_answer_says_so() -> None:
    figure = draw_ablation(Ablation(controls=(), answers=()))
    assert figure.get_suptitle() == "No condition is complete yet"
