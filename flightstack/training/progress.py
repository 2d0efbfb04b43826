"""How a training goes, epoch by epoch: what is left of it, curves.csv, and curves.png beside it."""

import csv
import io
import math
import statistics
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

from flightstack.files import replacing, write_whole
from flightstack.libraries import MissingLibraryError, load_library

CURVES_FILE, PICTURE_FILE = "curves.csv", "curves.png"
EPOCH, WALL = "epoch", "wall_s"
REDRAWN_S = 5.0  # a picture takes a third of a second: short epochs do not each draw one
UNDRAWN = (EPOCH, WALL)
COLUMNS, PANEL_IN = 3, (3.6, 2.3)  # of the picture
EXTRA = "training"
Value = float | None  # None: not measured in this epoch
Clock = Callable[[], float]
Report = Callable[[str], None]


class Curves:
    """The figures of a run's epochs, kept in its folder; rows of epochs to come are dropped."""

    def __init__(
        self,
        folder: Path,
        *,
        done: int,
        epochs: int,
        report: Report = print,
        clock: Clock = time.monotonic,
    ) -> None:
        self._folder, self._epochs, self._clock, self._report = folder, epochs, clock, report
        self._rows = _read_rows(folder / CURVES_FILE, done)
        self._walls: list[float] = []
        self._started = clock()
        self._drawn = -math.inf
        self._can_draw = True

    def add(self, epoch: int, **values: Value) -> str:
        """Note an epoch that is done, with its figures; returns what is left, such as "3 min"."""
        now = self._clock()
        wall_s = now - self._started
        self._walls.append(wall_s)
        self._rows.append({EPOCH: float(epoch), **values, WALL: round(wall_s, 3)})
        write_whole(self._folder / CURVES_FILE, rows_text(self._rows))
        if epoch == self._epochs or now - self._drawn >= REDRAWN_S:
            self._draw()
            self._drawn = now
        self._started = self._clock()
        return duration_text((self._epochs - epoch) * statistics.median(self._walls))

    def _draw(self) -> None:
        if not self._can_draw:
            return
        try:
            draw_curves(self._rows, self._folder / PICTURE_FILE)
        except MissingLibraryError as error:
            self._can_draw = False
            self._report(f"{self._folder.name}: {CURVES_FILE} without {PICTURE_FILE}: {error}")


def duration_text(seconds: float) -> str:
    """Say a duration as a person would: "40 s", "12 min", "3.5 h"."""
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 5400.0 else f"{seconds / 3600:.1f} h"


def rows_text(rows: list[dict[str, Value]]) -> str:
    """Write rows as CSV, a column for whatever any of them has; what was not measured is empty."""
    names = [*dict.fromkeys(name for row in rows for name in row if name != WALL), WALL]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(names)
    writer.writerows([_cell(name, row.get(name)) for name in names] for row in rows)
    return text.getvalue()


def draw_curves(rows: list[Mapping[str, Value]] | list[dict[str, Value]], path: Path) -> None:
    """Draw each column over the epochs; raises MissingLibraryError without matplotlib."""
    figure_class = load_library("matplotlib.figure", EXTRA).Figure
    names = [name for name in dict.fromkeys(n for row in rows for n in row) if name not in UNDRAWN]
    lines = math.ceil(len(names) / COLUMNS)
    figure = figure_class(
        figsize=(COLUMNS * PANEL_IN[0], lines * PANEL_IN[1]), layout="constrained"
    )
    load_library("matplotlib.backends.backend_agg", EXTRA).FigureCanvasAgg(figure)
    for panel, name in zip(
        figure.subplots(lines, COLUMNS, squeeze=False).flat, names, strict=False
    ):
        _draw_panel(panel, name, rows)
    for panel in figure.axes[len(names) :]:
        panel.remove()
    with replacing(path) as draft:
        figure.savefig(draft, format="png", dpi=110, metadata={"Software": None})


def _draw_panel(panel: Any, name: str, rows: list[Any]) -> None:
    points = [(row[EPOCH], row[name]) for row in rows if row.get(name) is not None]
    panel.plot(*zip(*points, strict=True), marker="." if len(points) < 30 else None)
    panel.set_title(name, fontsize=9, loc="left")
    panel.set_xlim(0.0, rows[-1][EPOCH] + 0.5)
    panel.locator_params(axis="x", integer=True, nbins=6)
    panel.tick_params(labelsize=8)
    panel.grid(color="#dfe4e9", linewidth=0.8)
    panel.spines[["top", "right"]].set_visible(False)


def _cell(name: str, value: Value) -> str:
    if value is None:
        return ""
    return str(int(value)) if name == EPOCH else f"{value:.6g}"


def _read_rows(path: Path, done: int) -> list[dict[str, Value]]:
    """Read the rows of the epochs that are done; none where the file is not one of these."""
    if not path.is_file() or done == 0:
        return []
    try:
        with path.open(newline="") as file:
            read = [
                {name: float(cell) if cell else None for name, cell in row.items()}
                for row in csv.DictReader(file)
            ]
        return [row for row in read if (row[EPOCH] or 0.0) <= done]
    except (OSError, ValueError, KeyError, TypeError):
        return []
