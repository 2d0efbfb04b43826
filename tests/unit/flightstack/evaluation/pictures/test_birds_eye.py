"""From above: where trials flew, how unsure they were, where they failed, and the gates."""

import numpy as np
import pytest

from flightstack.evaluation.flights.trace import Trace
from flightstack.evaluation.pictures.birds_eye import Way, draw_birds_eye, gate_bars

pytest.importorskip("matplotlib")


def made_way(*, is_full: bool, north: float = 0.0) -> Way:
    position = np.array([[north, 0.0, -3.0], [north + 2.0, 1.0, -3.0], [north + 4.0, 3.0, -4.0]])
    gates = np.array([[5.0, 0.0, -3.0, 0.0], [9.0, 4.0, -3.0, np.pi / 2]])
    trace = Trace(
        time_s=np.arange(3) / 20,
        position_ned=position,
        uncertainty=np.array([0.1, 0.2, 0.6]),
        gates=gates,
    )
    return Way(trace, is_full)


def test_ways_lie_east_and_north_and_failures_are_marked() -> None:
    ways = {
        ("m0", "level1"): [made_way(is_full=True), made_way(is_full=False, north=7.0)],
        ("m1", "level2"): [made_way(is_full=True)],
    }
    figure = draw_birds_eye(ways)
    plots = figure.axes[:4]
    names = [plot.get_title(loc="left") for plot in plots]
    assert names == ["m0, level1", "m0, level2", "m1, level1", "m1, level2"]
    assert [len(plot.collections) for plot in plots] == [4, 0, 0, 2]
    *_, first, second = plots[0].collections
    assert np.array(first.get_segments()).tolist() == [
        [[0.0, 0.0], [1.0, 2.0]],
        [[1.0, 2.0], [3.0, 4.0]],
    ]
    assert second.get_segments()[0][0].tolist() == [0.0, 7.0]
    (failure,) = plots[0].lines
    assert (failure.get_xdata().tolist(), failure.get_ydata().tolist()) == ([3.0], [11.0])
    assert [plot.texts[0].get_text() for plot in plots] == [
        "1 of 2 whole",
        "0 of 0 whole",
        "0 of 0 whole",
        "1 of 1 whole",
    ]
    assert "m/s" in figure.axes[4].get_ylabel()


def test_colour_follows_uncertainty_on_one_scale() -> None:
    figure = draw_birds_eye({("m0", "level1"): [made_way(is_full=True)]})
    path = figure.axes[0].collections[-1]
    brightness = path.get_colors()[:, :3].sum(axis=1)
    assert brightness[1] > brightness[0], "viridis: the less sure, the brighter"
    low, high = figure.axes[1].get_ylim()
    assert (low, high) == (0.0, pytest.approx(np.percentile([0.1, 0.2, 0.6], 98)))


def test_gates_stand_across_the_way_through_them() -> None:
    north_bound, east_bound = gate_bars(np.array([[5.0, 1.0, -3.0, 0.0], [5, 1, -3, np.pi / 2]]))
    assert np.ptp(north_bound[:, 0]) == pytest.approx(1.2)
    assert np.ptp(north_bound[:, 1]) == pytest.approx(0.0)
    assert np.ptp(east_bound[:, 0]) == pytest.approx(0.0)
    assert east_bound.mean(axis=0).tolist() == pytest.approx([1.0, 5.0])


def test_many_conditions_go_on_in_the_next_line() -> None:
    ways = {("m0", f"rung{n}"): [made_way(is_full=True)] for n in range(8)}
    plots = draw_birds_eye(ways).axes[:12]
    assert [plot.axison for plot in plots] == [True] * 8 + [False] * 4
