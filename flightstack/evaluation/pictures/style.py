"""One look for all pictures: an opaque ground, readable on light pages and on dark ones.

Reference: Okabe and Ito 2008, "Color universal design": colours that the colour-blind tell apart.
"""

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from flightstack.libraries import load_library

GROUND, INK, MUTED, RULE = "#ffffff", "#1c2733", "#6b7785", "#dfe4e9"
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#1c2733")
MARKERS = ("o", "s", "^", "D", "v", "P", "X")
LINES = ("-", "--", ":", "-.")
DOTS_PER_INCH = 150


@dataclass(frozen=True, slots=True)
class SeriesStyle:
    """How one row of the table is drawn in every picture: told by colour and, in grey, by form."""

    colour: str
    marker: str
    line: str


def series_styles(names: Sequence[str]) -> dict[str, SeriesStyle]:
    """Give every row a look of its own, in order."""
    forms = itertools.product(LINES, zip(COLOURS, MARKERS, strict=True))
    pairs = zip(names, itertools.cycle(forms), strict=False)
    return {name: SeriesStyle(colour, marker, line) for name, (line, (colour, marker)) in pairs}


def new_figure(width_in: float, height_in: float) -> Any:
    """Return an empty matplotlib figure; raises MissingLibraryError without matplotlib."""
    figure = load_library("matplotlib.figure", "evaluation").Figure(
        figsize=(width_in, height_in), layout="constrained", facecolor=GROUND
    )
    load_library("matplotlib.backends.backend_agg", "evaluation").FigureCanvasAgg(figure)
    return figure


def plain(plot: Any, *, grid: str = "both") -> None:
    """Take the box from around a plot, and lay a faint grid under it."""
    plot.set_facecolor(GROUND)
    plot.spines[["top", "right"]].set_visible(False)
    plot.spines[["left", "bottom"]].set_color(MUTED)
    plot.tick_params(colors=INK, labelsize=9)
    plot.grid(axis=grid, color=RULE, linewidth=0.8)
    plot.set_axisbelow(True)


def save(figure: Any, path: Path) -> None:
    """Write a PNG; the same picture gives the same bytes."""
    figure.savefig(path, dpi=DOTS_PER_INCH, facecolor=GROUND, metadata={"Software": None})
