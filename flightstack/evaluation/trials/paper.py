"""Table II of the paper: its rows, its levels of noise, and the gates that it reports.

References:
    Arnez et al. 2022, "Quantifying and Using System Uncertainty in UAV Navigation", Table II.
"""

from flightstack.errors import UsageError
from flightstack.evaluation.trials.experiment import Competitor, Condition
from flightstack.evaluation.trials.rungs import MAX_NOISE_M, load_rung

GATES = 32  # 4 laps
LEVELS = ("level1", "level2")  # rungs of the ladder, too
STRATEGIES = {"mi-mode": "mi-mode", "mean": "de-mean"}
MEAN_GATES = {  # of 32, by row and level; 6 tracks x 2 trials
    "m0-mi-mode": {"level1": 28.88, "level2": 23.05},
    "m0-mean": {"level1": 19.77, "level2": 9.22},
    "m1-mean": {"level1": 17.67, "level2": 6.0},
    "m2-mean": {"level1": 17.33, "level2": 4.0},
    "m3-mean": {"level1": 8.33, "level2": 5.0},
    "m4-mean": {"level1": 15.16, "level2": 4.38},
}


def rows(recipe: str, names: tuple[str, ...] = tuple(MEAN_GATES)) -> tuple[Competitor, ...]:
    """Return rows of the table, flown by the models of a recipe; raises UsageError."""
    unknown = next((name for name in names if name not in MEAN_GATES), None)
    if unknown is not None:
        raise UsageError(f"unknown row {unknown!r}: choose of {', '.join(MEAN_GATES)}")
    return tuple(_row(recipe, name) for name in names)


def level(text: str) -> Condition:
    """Make a condition of "1", "2", "level1", or of other noise as "2.0,4.0" (m)."""
    name = f"level{text}" if f"level{text}" in LEVELS else text
    known = {name: load_rung(name)[1] for name in LEVELS}
    if name in known:
        return known[name]
    try:
        radius_m, height_m = map(float, text.split(","))
    except ValueError:
        radius_m = height_m = -1.0
    if not (0.0 <= radius_m <= MAX_NOISE_M[0] and 0.0 <= height_m <= MAX_NOISE_M[1]):
        raise UsageError(f"level {text!r}: expected 1, 2, or noise in m such as 2.0,4.0")
    own = Condition(name=f"noise-{radius_m:g}-{height_m:g}", noise_m=(radius_m, height_m))
    return next((level for level in known.values() if level.noise_m == own.noise_m), own)


def _row(recipe: str, name: str) -> Competitor:
    model, _, decision = name.partition("-")
    return Competitor(name=name, model=f"{recipe}/{model}", strategy=STRATEGIES[decision])
