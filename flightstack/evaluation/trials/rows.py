"""One CSV row per trial: all that tables and pictures are made from.

Rows hold no wall time and do not depend on the order of flying.
"""

import csv
import io
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any, get_type_hints

from flightstack.errors import UsageError
from flightstack.evaluation.trials.experiment import Key
from flightstack.records import VELOCITIES

PARTS = ("aleatoric", "epistemic", "perceptual")
FINISHED, MISSED, COLLISION, TIMEOUT = "finished", "missed", "collision", "timeout"
DECIMALS = 6


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialRow:
    """What came of one trial. Deviations are the decisions' mean, in m/s and rad/s."""

    experiment: str
    row: str
    model: str
    strategy: str
    command_factor: float
    condition: str
    noise_radius_m: float
    noise_height_m: float
    direction: str
    track_seed: int
    trial: int
    seed: int
    gates_passed: int
    gates_total: int
    outcome: str  # finished, missed, collision, timeout, or how else it ended
    failed_gate: int | None  # from 1, over all laps; None where it finished
    failure: str  # in the referee's words
    duration_s: float  # vehicle time from the first decision to the end
    mean_speed_m_s: float
    command_vx_m_s: float  # the decisions' mean
    aleatoric_vx: float
    aleatoric_vy: float
    aleatoric_vz: float
    aleatoric_yaw_rate: float
    epistemic_vx: float
    epistemic_vy: float
    epistemic_vz: float
    epistemic_yaw_rate: float
    perceptual_vx: float
    perceptual_vy: float
    perceptual_vz: float
    perceptual_yaw_rate: float
    multimodal_share: float  # of the decisions, where any velocity had several modes
    retries: int  # flights that died before this one
    commit: str
    weights_sha256: str

    @property
    def key(self) -> Key:
        """What tells it from all other trials of its experiment."""
        return self.row, self.condition, self.track_seed, self.trial

    @property
    def is_full(self) -> bool:
        """Whether the whole course was flown."""
        return self.gates_passed == self.gates_total


COLUMNS = tuple(field.name for field in fields(TrialRow))
DEVIATIONS = tuple(f"{part}_{velocity}" for part in PARTS for velocity in VELOCITIES)
_KINDS = get_type_hints(TrialRow)


def to_line(row: TrialRow) -> str:
    """Write a row as one line of CSV, its end included."""
    return _csv_line([_to_text(getattr(row, name)) for name in COLUMNS])


def header_line() -> str:
    """Write the names of the columns."""
    return _csv_line(COLUMNS)


def read_rows(path: Path) -> list[TrialRow]:
    """Read `trials.csv`; a last line that was cut off is left out. Raises UsageError."""
    try:
        with path.open(newline="") as file:
            text = file.read()
    except (OSError, UnicodeDecodeError) as error:
        raise UsageError(f"{path} cannot be read: {error}") from error
    whole = text[: text.rfind("\n") + 1]
    lines = list(csv.reader(io.StringIO(whole)))
    if not lines or tuple(lines[0]) != COLUMNS:
        raise UsageError(f"{path} is no table of trials: its first line names other columns")
    try:
        return [_from_texts(line) for line in lines[1:]]
    except ValueError as error:
        raise UsageError(f"{path} is damaged: {error}") from error


def by_cell(rows: Iterable[TrialRow]) -> dict[tuple[str, str], list[TrialRow]]:
    """Group rows by (row, condition), in the order of their first appearance."""
    cells: dict[tuple[str, str], list[TrialRow]] = {}
    for row in rows:
        cells.setdefault((row.row, row.condition), []).append(row)
    return cells


def by_track(rows: Iterable[TrialRow], value: str) -> dict[int, float]:
    """Average a column (or property) of one cell over the trials of each track."""
    found: dict[int, list[float]] = {}
    for row in rows:
        found.setdefault(row.track_seed, []).append(float(getattr(row, value)))
    return {track: sum(values) / len(values) for track, values in sorted(found.items())}


def _csv_line(texts: Sequence[str]) -> str:
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerow(texts)
    return out.getvalue()


def _to_text(value: Any) -> str:
    if value is None:
        return ""
    return repr(round(value, DECIMALS)) if isinstance(value, float) else str(value)


def _from_texts(texts: list[str]) -> TrialRow:
    values = {
        name: _from_text(_KINDS[name], text) for name, text in zip(COLUMNS, texts, strict=True)
    }
    return TrialRow(**values)


def _from_text(kind: Any, text: str) -> Any:
    if kind == int | None:
        return int(text) if text else None
    return kind(text)
