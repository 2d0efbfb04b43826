"""What an experiment asks for: every row under every condition, on the same tracks.

    Competitor  who flies: a model, a strategy           one row of a table
    Condition   in what: noise, direction, the vehicle    one column of it
    Trial       one flight of a row in a condition

The seed of a trial is a pure function of its track and its number: every model meets the same
tracks, the same light and the same chance.
"""

import re
from collections.abc import Iterator
from dataclasses import asdict, dataclass

import numpy as np

from flightstack.errors import UsageError
from flightstack.training.seeds import TEST_TRACKS

FIRST_TRACK = 1000  # those before are flown by hand, by tests and in documents
MAX_COUNT = 1000  # laps, or trials on a track: more is a slip of the finger
PILOT_OPTION = "--pilot="
Key = tuple[str, str, int, int]  # row, condition, track and trial
NAME = re.compile(r"[a-z0-9][a-z0-9._+]*(-[a-z0-9._+]+)*")  # also part of a file's name


@dataclass(frozen=True, slots=True, kw_only=True)
class Competitor:
    """One line of a table: who flies."""

    name: str
    model: str  # "paper/m0", or the path of a model's folder
    strategy: str
    command_factor: float = 1.0  # on the velocities
    companion_options: tuple[str, ...] = ()  # such as "--policy=my_package:MyPolicy"

    def __post_init__(self) -> None:
        _check_name("row", self.name)

    @property
    def pilot(self) -> str | None:
        """The end-to-end policy that flies in place of a model; its name is the model's, too."""
        options = (text for text in self.companion_options if text.startswith(PILOT_OPTION))
        return next((text.removeprefix(PILOT_OPTION) for text in options), None)


@dataclass(frozen=True, slots=True, kw_only=True)
class Condition:
    """One column of a table: what the vehicle meets."""

    name: str
    noise_m: tuple[float, float]  # of the gates' radius and height
    direction: str = "cw"
    command_factor: float = 1.0  # times the row's
    vehicle_options: tuple[str, ...] = ()  # of `python -m sitl`

    def __post_init__(self) -> None:
        _check_name("condition", self.name)


@dataclass(frozen=True, slots=True, kw_only=True)
class Trial:
    """One flight."""

    row: Competitor
    condition: Condition
    track_seed: int
    trial: int  # from 0: repetitions on one track
    laps: int

    @property
    def seed(self) -> int:
        """Of the vehicle's light and sensors, and of the companion's samples."""
        return int(np.random.SeedSequence([self.track_seed, self.trial]).generate_state(1)[0])

    @property
    def command_factor(self) -> float:
        """On the velocities that are commanded."""
        return self.row.command_factor * self.condition.command_factor

    @property
    def key(self) -> Key:
        """What tells it from all others of its experiment."""
        return self.row.name, self.condition.name, self.track_seed, self.trial

    def __str__(self) -> str:
        return "-".join(map(str, self.key))


@dataclass(frozen=True, slots=True, kw_only=True)
class Experiment:
    """Rows times conditions times tracks times trials."""

    name: str  # "table", "ladder", ...
    rows: tuple[Competitor, ...]
    conditions: tuple[Condition, ...]
    track_seeds: tuple[int, ...]
    trials: int  # on each track
    laps: int = 4

    def __post_init__(self) -> None:
        for what, count in (("trials", self.trials), ("laps", self.laps)):
            if count < 1:
                raise UsageError(f"{what} must be 1 or more, got {count}")
            if count > MAX_COUNT:
                raise UsageError(f"{what} must be {MAX_COUNT} or fewer, got {count}")
        if not (self.rows and self.conditions and self.track_seeds):
            raise UsageError(f"{self.name}: there must be a row, a condition and a track")
        for kind, names in (
            ("row", [row.name for row in self.rows]),
            ("condition", [condition.name for condition in self.conditions]),
            ("track", list(map(str, self.track_seeds))),
        ):
            twice = next((name for name in names if names.count(name) > 1), None)
            if twice is not None:
                raise UsageError(f"{kind} {twice} is asked for twice")

    def plan(self) -> Iterator[Trial]:
        """Yield all trials; any first part of them is spread evenly over rows and conditions."""
        for track_seed in self.track_seeds:
            for trial in range(self.trials):
                for condition in self.conditions:
                    for row in self.rows:
                        yield Trial(
                            row=row,
                            condition=condition,
                            track_seed=track_seed,
                            trial=trial,
                            laps=self.laps,
                        )

    def as_table(self) -> dict[str, object]:
        """Return what JSON can hold, all of it."""
        return asdict(self)


def tracks(count: int, first: int = FIRST_TRACK) -> tuple[int, ...]:
    """Name so many test tracks, one after another; raises UsageError where there are none."""
    if count < 1:
        raise UsageError(f"tracks must be 1 or more, got {count}")
    if first not in TEST_TRACKS or first + count - 1 not in TEST_TRACKS:
        raise UsageError(f"test tracks are {TEST_TRACKS[0]} to {TEST_TRACKS[-1]}, got {first}")
    return tuple(range(first, first + count))


def _check_name(kind: str, name: str) -> None:
    if not NAME.fullmatch(name):
        raise UsageError(f"{kind} {name!r}: a name is of a-z, 0-9, '.', '_', '+' and single '-'")
