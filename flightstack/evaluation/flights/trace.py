"""The way of one trial, for pictures: where the vehicle was at each decision, and how unsure."""

from dataclasses import dataclass
from pathlib import Path
from typing import Self
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from flightstack.errors import UsageError
from flightstack.logs.columns.log import Log
from flightstack.logs.flight.course import find_gates
from flightstack.logs.flight.decisions import Decisions

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Trace:
    """One entry per decision, 20 per second; positions by the vehicle's own estimate."""

    time_s: Floats  # (T,) vehicle time since the first decision
    position_ned: Floats  # (T, 3) m
    uncertainty: Floats  # (T,) m/s, all parts over the three linear velocities
    gates: Floats  # (G, 4) centre in m NED, yaw in rad, in the order of the course

    @classmethod
    def of(cls, log: Log, decisions: Decisions) -> Self:
        """Read it from the companion's log."""
        stamps_us = decisions.stamp_us
        began_us = stamps_us[0] if len(stamps_us) else 0
        return cls(
            time_s=(stamps_us - began_us) / 1e6,
            position_ned=positions(log, stamps_us),
            uncertainty=decisions.total_std_m_s,
            gates=np.array(
                [(*gate.centre_ned, gate.yaw_rad) for gate in find_gates(log)], dtype=np.float64
            ).reshape(-1, 4),
        )

    def save(self, path: Path) -> None:
        """Write a .npz file."""
        np.savez_compressed(
            path,
            time_s=self.time_s,
            position_ned=self.position_ned,
            uncertainty=self.uncertainty,
            gates=self.gates,
        )

    @classmethod
    def load(cls, path: Path) -> Self:
        """Read a .npz file; raises UsageError."""
        try:
            with np.load(path) as arrays:
                return cls(**{name: arrays[name] for name in arrays.files})
        except (OSError, EOFError, ValueError, TypeError, BadZipFile) as error:
            raise UsageError(f"{path} is damaged: remove it, and its picture lacks it") from error


def positions(log: Log, stamps_us: NDArray[np.int64]) -> Floats:
    """Interpolate the position (T, 3) at these moments of vehicle time."""
    table = log["LOCAL_POSITION_NED"]
    if not len(table):
        return np.full((len(stamps_us), 3), np.nan)
    known_us = table["time_boot_ms"].astype(np.int64) * 1000
    axes = [np.interp(stamps_us, known_us, table[axis]) for axis in ("x", "y", "z")]
    return np.stack(axes, axis=1)


def speeds(log: Log, start_us: int, end_us: int) -> Floats:
    """Return the speeds (m/s) that were told between two moments of vehicle time."""
    table = log["LOCAL_POSITION_NED"]
    known_us = table["time_boot_ms"].astype(np.int64) * 1000
    flown = table.take((known_us >= start_us) & (known_us <= end_us))
    velocity = np.stack([flown[axis] for axis in ("vx", "vy", "vz")], axis=1)
    return np.asarray(np.linalg.norm(velocity.astype(np.float64), axis=1))
