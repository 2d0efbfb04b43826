"""Read what the companion said of each decision: DEBUG_FLOAT_ARRAY "decision" and "members"."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.columns.log import Log
from flightstack.mavlink_numbers import AUTOPILOT_COMPONENT

VELOCITIES = ("vx", "vy", "vz", "yaw rate")  # body frame: forward, right, down; clockwise
UNITS = ("m/s", "m/s", "m/s", "rad/s")
ALL_MEMBERS = -1  # the decision pooled every member
LINEAR = slice(0, 3)
PARTS = ("aleatoric", "epistemic", "perceptual")  # of the uncertainty

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Decisions:
    """One row a decision; columns in the order of VELOCITIES."""

    time_us: NDArray[np.int64]  # when it was logged, since 1970
    stamp_us: NDArray[np.int64]  # of the camera image that it answers, vehicle time
    aleatoric_std: Floats  # (n, 4) m/s, rad/s
    epistemic_std: Floats
    perceptual_std: Floats
    score: Floats  # of the chosen member, nats
    member: NDArray[np.int64]  # (n, 4) or ALL_MEMBERS
    modes: NDArray[np.int64]
    command: Floats  # (n, 4) m/s, rad/s
    image_age_s: Floats  # (n,) when the image was received; 0 where nobody knows, and in lockstep

    def __len__(self) -> int:
        return len(self.time_us)

    @property
    def total_std_m_s(self) -> Floats:
        """All kinds of uncertainty over the three linear velocities in one number."""
        parts = (self.aleatoric_std, self.epistemic_std, self.perceptual_std)
        squares = [np.square(part[:, LINEAR]).sum(axis=1) for part in parts]
        total: Floats = np.sqrt(np.sum(squares, axis=0))
        return total


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MemberPredictions:
    """What each policy member would have commanded, averaged over the latent samples."""

    stamp_us: NDArray[np.int64]
    mean: Floats  # (n, N, 4) m/s, rad/s


def _arrays(
    log: Log, name: str, length: int
) -> tuple[NDArray[np.int64], NDArray[np.int64], Floats]:
    """Return times, stamps and the first values of the arrays of that name, from who made them.

    A PX4 that hears them sends them on as its own, under new stamps: those are left out.
    """
    table = log["DEBUG_FLOAT_ARRAY"]
    rows = np.flatnonzero(table.data["name"] == name.encode())
    echoed = table.component[rows] == AUTOPILOT_COMPONENT
    if not echoed.all():
        rows = rows[~echoed]
    stamp_us = table.data["time_usec"][rows].astype(np.int64)
    data = table.data["data"][rows, :length]
    return table.time_us[rows], stamp_us, data.astype(np.float64)


def find_decisions(log: Log) -> Decisions:
    """Return the decisions of a log; none is an empty record."""
    time_us, stamp_us, data = _arrays(log, "decision", 29)
    parts = data[:, :28].reshape(len(data), 7, 4)
    return Decisions(
        time_us=time_us,
        stamp_us=stamp_us,
        aleatoric_std=parts[:, 0],
        epistemic_std=parts[:, 1],
        perceptual_std=parts[:, 2],
        score=parts[:, 3],
        member=parts[:, 4].astype(np.int64),
        modes=parts[:, 5].astype(np.int64),
        command=parts[:, 6],
        image_age_s=data[:, 28],
    )


def find_members(log: Log) -> MemberPredictions:
    """Return the predictions member by member; empty unless images were recorded."""
    _, stamp_us, data = _arrays(log, "members", 56)
    padded = data.reshape(len(data), 14, 4)
    used = np.flatnonzero(np.any(padded != 0, axis=(0, 2)))
    count = int(used[-1]) + 1 if len(used) else 0
    return MemberPredictions(stamp_us=stamp_us, mean=padded[:, :count])
