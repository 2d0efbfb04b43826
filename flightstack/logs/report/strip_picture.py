"""Draw the moments before a failed gate as one picture."""

from pathlib import Path
from typing import Any

import numpy as np

from flightstack.libraries import load_pyplot
from flightstack.logs.errors import LogFileError
from flightstack.logs.flight.decisions import PARTS, VELOCITIES
from flightstack.logs.flight.why import FailedGate, Moment
from flightstack.logs.report.plotting import PART_COLOURS


def _picture(axes: Any, moment: Moment, read: Any) -> None:
    axes.set_title(f"{-moment.before_s:.2f} s", fontsize=9)
    axes.set_xticks([])
    axes.set_yticks([])
    if moment.image is None:
        axes.text(0.5, 0.5, "not\nrecorded", ha="center", va="center", transform=axes.transAxes)
    else:
        axes.imshow(read(moment.image), interpolation="nearest")


def _members(axes: Any, moment: Moment, limits: tuple[float, float]) -> None:
    rows = np.arange(len(VELOCITIES))
    for number, prediction in enumerate(moment.predictions):
        chosen = moment.member == number
        axes.scatter(prediction[~chosen], rows[~chosen], s=12, facecolors="none", edgecolors="grey")
        axes.scatter(prediction[chosen], rows[chosen], s=14, color="#1f6feb")
    axes.scatter(moment.command, rows, marker="|", s=120, color="#b3261e")
    axes.set_yticks(rows, VELOCITIES if axes.get_subplotspec().is_first_col() else [])
    axes.set_xlim(*limits)
    axes.invert_yaxis()
    axes.tick_params(labelsize=7)


def _bars(axes: Any, moment: Moment, longest: float) -> None:
    rows = range(len(PARTS))
    axes.barh(rows, list(map(moment.std_m_s, PARTS)), color=list(PART_COLOURS.values()))
    axes.set_yticks(rows, PARTS if axes.get_subplotspec().is_first_col() else [])
    axes.set_xlim(0, longest)
    axes.invert_yaxis()
    axes.tick_params(labelsize=7)


def draw_strip(failure: FailedGate, output: Path) -> None:
    """Draw pictures, predictions and uncertainty, one column a moment."""
    pyplot = load_pyplot("logs")
    moments = failure.moments
    if not moments:
        raise LogFileError("the log holds no decisions of the seconds before: nothing to draw")
    values = failure.velocities()
    limits = (float(values.min()) - 0.1, float(values.max()) + 0.1)
    figure, axes = pyplot.subplots(
        3,
        len(moments),
        squeeze=False,
        figsize=(1.5 * len(moments) + 0.8, 4.6),
        height_ratios=[1.5, 1.2, 0.7],
    )
    for column, moment in enumerate(moments):
        _picture(axes[0, column], moment, pyplot.imread)
        _members(axes[1, column], moment, limits)
        _bars(axes[2, column], moment, 1.05 * failure.max_std_m_s())
    figure.suptitle(failure.event.text, fontsize=11)
    figure.tight_layout()
    try:
        figure.savefig(output, dpi=120)
    except (OSError, ValueError) as error:
        raise LogFileError(f"{output} cannot be written: {error}") from error
    finally:
        pyplot.close(figure)
