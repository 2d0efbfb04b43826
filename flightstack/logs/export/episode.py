"""One flight as an episode: each image that was answered, the state then, the action, its doubt."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.errors import LogFileError
from flightstack.logs.flight.decisions import PARTS, VELOCITIES
from flightstack.logs.flight.flight import Flight
from flightstack.logs.seen import UNDECIDED, find_seen, rate_hz

STATE = ("forward m/s", "right m/s", "down m/s", "yaw rate rad/s", "roll rad", "pitch rad")
ACTION = VELOCITIES
UNCERTAINTY = tuple(f"{part} {name}" for part in PARTS for name in VELOCITIES)

Singles = NDArray[np.float32]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Episode:
    """One row an image that a decision answers."""

    paths: tuple[Path, ...]
    stamp_us: NDArray[np.int64]  # vehicle time
    state: Singles  # (n, 6) STATE
    action: Singles  # (n, 4) what was commanded
    uncertainty: Singles  # (n, 12) standard deviations

    def __len__(self) -> int:
        return len(self.paths)

    @property
    def rate_hz(self) -> int:
        """How many images a second there are."""
        return rate_hz(self.stamp_us)


def find_episode(flight: Flight) -> Episode:
    """Return the part of a flight that was decided; LogFileError where there is none."""
    seen = find_seen(flight)
    attitude, flown = seen.attitude_rad[:, :2], seen.flown()
    state = np.hstack([flown, attitude]).astype(np.float32)
    rows = np.flatnonzero((seen.decision != UNDECIDED) & np.isfinite(state).all(axis=1))
    if len(rows) < 2:
        raise LogFileError(f"{flight.log.name} holds no decisions on its recorded images")
    decided = seen.decision[rows]
    decisions = flight.decisions
    parts = [getattr(decisions, f"{part}_std")[decided] for part in PARTS]
    return Episode(
        paths=tuple(seen.paths[row] for row in rows.tolist()),
        stamp_us=seen.stamp_us[rows],
        state=state[rows],
        action=decisions.command[decided].astype(np.float32),
        uncertainty=np.hstack(parts).astype(np.float32),
    )
