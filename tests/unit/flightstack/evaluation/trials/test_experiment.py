from itertools import islice

import pytest

from flightstack.errors import UsageError
from flightstack.evaluation.trials import paper
from flightstack.evaluation.trials.experiment import Competitor, Condition, Experiment, tracks

ROWS = paper.rows("paper")
CONDITIONS = tuple(paper.level(text) for text in ("1", "2"))


def experiment(**changes: object) -> Experiment:
    request = {"rows": ROWS, "conditions": CONDITIONS, "track_seeds": (5, 6), "trials": 2}
    return Experiment(name="table", **(request | changes))  # type: ignore[arg-type]


def test_every_row_meets_the_same_tracks_and_the_same_chance() -> None:
    met: dict[str, list[tuple[int, int]]] = {}
    for trial in experiment().plan():
        met.setdefault(f"{trial.row.name} {trial.condition.name}", []).append(
            (trial.track_seed, trial.seed)
        )
    assert len(met) == len(ROWS) * len(CONDITIONS)
    assert len(set(map(tuple, met.values()))) == 1
    seeds = [seed for _, seed in next(iter(met.values()))]
    assert len(set(seeds)) == 4  # 2 tracks, 2 trials


def test_a_first_part_of_the_plan_is_even_over_rows_and_conditions() -> None:
    first = list(islice(experiment().plan(), len(ROWS) * len(CONDITIONS)))
    assert len({(trial.row, trial.condition) for trial in first}) == len(first)
    assert {(trial.track_seed, trial.trial) for trial in first} == {(5, 0)}


def test_factors_of_row_and_condition_multiply() -> None:
    slow = Competitor(name="slow", model="paper/m0", strategy="de-mean", command_factor=0.8)
    fast = Condition(name="fast", noise_m=(1.0, 2.0), command_factor=2.0)
    trial = next(experiment(rows=(slow,), conditions=(fast,)).plan())
    assert trial.command_factor == pytest.approx(1.6)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"trials": 0}, "trials must be 1 or more, got 0"),
        ({"laps": 0}, "laps must be 1 or more, got 0"),
        ({"laps": 1_000_000_000}, "laps must be 1000 or fewer, got 1000000000"),
        ({"trials": 1001}, "trials must be 1000 or fewer, got 1001"),
        ({"rows": ()}, "there must be a row"),
        ({"rows": (ROWS[0], ROWS[0])}, "row m0-mi-mode is asked for twice"),
        ({"conditions": (CONDITIONS[0], CONDITIONS[0])}, "condition level1 is asked for twice"),
    ],
)
def test_refuses_what_cannot_be(changes: dict[str, object], said: str) -> None:
    with pytest.raises(UsageError, match=said):
        experiment(**changes)


@pytest.mark.parametrize(("count", "first"), [(0, 1000), (1, -1), (2, 999_999)])
def test_refuses_tracks_outside_the_test_range(count: int, first: int) -> None:
    with pytest.raises(UsageError):
        tracks(count, first)


def test_names_are_fit_for_files() -> None:
    with pytest.raises(UsageError, match="a name is of"):
        Competitor(name="M0/mean", model="paper/m0", strategy="de-mean")


@pytest.mark.parametrize(
    ("text", "name", "noise_m"),
    [
        ("1", "level1", (1.0, 2.0)),
        ("level2", "level2", (1.5, 3.0)),
        ("1.5,3", "level2", (1.5, 3.0)),
        ("2.0,4.0", "noise-2-4", (2.0, 4.0)),
        ("0.5,0", "noise-0.5-0", (0.5, 0.0)),
    ],
)
def test_reads_levels(text: str, name: str, noise_m: tuple[float, float]) -> None:
    assert paper.level(text) == Condition(name=name, noise_m=noise_m)


@pytest.mark.parametrize("text", ["3", "-1,2", "1.0", "1,2,3", "nan,1", "9,1", "one"])
def test_refuses_other_levels(text: str) -> None:
    with pytest.raises(UsageError, match="level"):
        paper.level(text)


def test_refuses_unknown_rows_of_the_table() -> None:
    with pytest.raises(UsageError, match="unknown row 'm5-mean': choose of m0-mi-mode"):
        paper.rows("paper", ("m5-mean",))
