"""Why did it miss? The moments before a gate was failed, as the companion saw and decided them.

A recording of camera images is a folder beside the log, <log>.frames, that holds one PNG per image,
named by its stamp in vehicle time: 000012345678.png.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.flight.course import CourseEvent
from flightstack.logs.flight.decisions import LINEAR, PARTS
from flightstack.logs.flight.flight import Flight

LOOK_BACK_S = 2.0
MAX_MOMENTS = 8

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Moment:
    """One decision before the failure; arrays have one value a velocity."""

    before_s: float  # how long before the failure
    stamp_us: int
    command: Floats  # (4,) m/s, rad/s
    aleatoric_std: Floats
    epistemic_std: Floats
    perceptual_std: Floats
    member: NDArray[np.int64]  # (4,)
    modes: NDArray[np.int64]
    predictions: Floats  # (N, 4) mean of each member; N is 0 where they were not recorded
    image: Path | None

    def std_m_s(self, part: str) -> float:
        """Return the length of one of PARTS of the uncertainty over the linear velocities."""
        return float(np.linalg.norm(getattr(self, f"{part}_std")[LINEAR]))


@dataclass(frozen=True, slots=True, kw_only=True)
class FailedGate:
    """A failed gate, and what led to it."""

    event: CourseEvent
    moments: tuple[Moment, ...]

    def max_std_m_s(self) -> float:
        """Return the largest part of the uncertainty of any moment."""
        return max(moment.std_m_s(part) for moment in self.moments for part in PARTS)

    def velocities(self) -> Floats:
        """Return all commands and predictions, (k, 4)."""
        return np.vstack([np.vstack([m.command, m.predictions]) for m in self.moments])


def images_folder(flight: Flight) -> Path:
    """Return where the images of a log are recorded by default."""
    return Path(flight.log.name).with_suffix(".frames")


def image_path(folder: Path, stamp_us: int) -> Path | None:
    """Return the recorded image with this stamp, None where there is none."""
    path = folder / f"{stamp_us:012d}.png"
    return path if path.is_file() else None


def find_failure(
    flight: Flight, folder: Path | None = None, seconds: float = LOOK_BACK_S
) -> FailedGate | None:
    """Return the first failed gate and the moments before it; None where nothing failed."""
    event = flight.first_failure
    if event is None:
        return None
    decisions, members = flight.decisions, flight.members
    before_us = event.time_us - decisions.time_us
    rows = np.flatnonzero((before_us >= 0) & (before_us <= seconds * 1e6))
    chosen = np.unique(np.linspace(0, max(len(rows) - 1, 0), MAX_MOMENTS).round().astype(np.intp))
    moments = []
    for row in rows[chosen].tolist() if len(rows) else []:
        stamp_us = int(decisions.stamp_us[row])
        same = np.flatnonzero(members.stamp_us == stamp_us)
        moments.append(
            Moment(
                before_s=float(before_us[row]) * 1e-6,
                stamp_us=stamp_us,
                command=decisions.command[row],
                aleatoric_std=decisions.aleatoric_std[row],
                epistemic_std=decisions.epistemic_std[row],
                perceptual_std=decisions.perceptual_std[row],
                member=decisions.member[row],
                modes=decisions.modes[row],
                predictions=members.mean[same[0]] if len(same) else np.empty((0, 4)),
                image=image_path(folder or images_folder(flight), stamp_us),
            )
        )
    return FailedGate(event=event, moments=tuple(moments))
