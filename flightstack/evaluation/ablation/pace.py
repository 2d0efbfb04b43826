"""Find for each strategy the constant factor on vx that flies as fast, on validation tracks.

The pace of a strategy is the mean vx that it commands while it flies. A constant factor on the
mean's vx changes what the camera sees next, so the pace is no plain product: the pace of a few
constant factors is flown, too, and the factor of each strategy is read off between them.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from flightstack.errors import UsageError
from flightstack.evaluation.trials.rows import TrialRow
from flightstack.training.seeds import VALIDATION_TRACKS

FACTORS = (0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1)  # that are flown to know what a factor does
STEP = 0.02  # factors are rounded to it, so that strategies of one pace share a control


@dataclass(frozen=True, slots=True, kw_only=True)
class Control:
    """The constant factor that flies as fast as a strategy."""

    strategy: str
    pace_m_s: float  # mean commanded vx
    factor: float

    @property
    def rule(self) -> str:
        """The control as a strategy; factor 1 is the plain mean."""
        return constant(self.factor)


def constant(factor: float) -> str:
    """Name the strategy that flies the mean with a constant factor on vx."""
    return "de-mean" if factor == 1.0 else f"all/mean/slow:{factor:.2f}"


def validation_tracks(count: int) -> tuple[int, ...]:
    """Name the first validation tracks; raises UsageError where there are none."""
    if not 1 <= count <= len(VALIDATION_TRACKS):
        raise UsageError(f"--validation-tracks must be 1 or more, got {count}")
    return tuple(VALIDATION_TRACKS[:count])


def paces(rows: Iterable[TrialRow]) -> dict[str, float]:
    """Average the commanded vx (m/s) of each strategy over the time that it flew."""
    sums: dict[str, tuple[float, float]] = {}
    for row in rows:
        if np.isfinite(row.command_vx_m_s):
            way, time = sums.get(row.strategy, (0.0, 0.0))
            sums[row.strategy] = (way + row.command_vx_m_s * row.duration_s, time + row.duration_s)
    return {strategy: way / time for strategy, (way, time) in sums.items() if time > 0.0}


def find_controls(strategies: Sequence[str], pace: Mapping[str, float]) -> dict[str, Control]:
    """Read each strategy's factor off what the constant factors flew.

    Raises UsageError where the pace of one is unknown.
    """
    unknown = next(
        (name for name in (*strategies, *map(constant, FACTORS)) if name not in pace), None
    )
    if unknown is not None:
        raise UsageError(f"no flight of the calibration tells the pace of {unknown}")
    flown = [pace[constant(factor)] for factor in FACTORS]
    rising = np.maximum.accumulate(flown)  # what chance lets fall must not confuse the reading
    controls = {}
    for strategy in strategies:
        factor = float(np.interp(pace[strategy], rising, FACTORS))
        controls[strategy] = Control(
            strategy=strategy,
            pace_m_s=pace[strategy],
            factor=1.0 if strategy == "de-mean" else round(round(factor / STEP) * STEP, 2),
        )
    return controls
