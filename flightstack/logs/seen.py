"""What the camera saw: each recorded image, where the vehicle was then, what was decided on it."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.columns.time_axis import placed_us
from flightstack.logs.errors import LogFileError
from flightstack.logs.flight.flight import Flight
from flightstack.logs.flight.motion import interpolated
from flightstack.logs.flight.why import images_folder
from flightstack.mavlink_numbers import REFEREE_COMPONENT

IMAGES = "[0-9]" * 12 + ".png"  # named by their stamp, us of vehicle time
UNDECIDED = -1
TOLD_MS = 1000  # us
GAP = 1.75  # times the usual step: an image is missing

Floats = NDArray[np.float64]
Numbers = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class SeenImages:
    """One row an image, in order of time; NaN where the log says nothing."""

    paths: tuple[Path, ...]
    stamp_us: Numbers  # vehicle time
    time_us: Numbers  # on the axis of the log
    position_ned: Floats  # (n, 3) m
    velocity_ned: Floats  # (n, 3) m/s
    attitude_rad: Floats  # (n, 3) roll, pitch, yaw; yaw without jumps
    decision: Numbers  # row of the flight's decisions, or UNDECIDED
    gates_passed: Numbers

    def __len__(self) -> int:
        return len(self.paths)

    def flown(self) -> Floats:
        """Return what was flown in the frame of the commands, level with the horizon, (n, 4)."""
        north, east, down = self.velocity_ned.T
        yaw = self.attitude_rad[:, 2]
        forward = np.cos(yaw) * north + np.sin(yaw) * east
        right = np.cos(yaw) * east - np.sin(yaw) * north
        turning = np.gradient(yaw, self.stamp_us * 1e-6) if len(yaw) > 1 else np.zeros(len(yaw))
        return np.stack([forward, right, down, turning], axis=1)


def rate_hz(stamp_us: Numbers) -> int:
    """Return how many images a second there are, where none is missing; 1 of a single one."""
    steps_us = np.diff(stamp_us)
    whole = steps_us[steps_us < GAP * np.median(steps_us)] if len(steps_us) else steps_us
    return max(round(1e6 / float(whole.mean())), 1) if len(whole) else 1


def find_seen(flight: Flight, folder: Path | None = None) -> SeenImages:
    """Return the images of a recording; by default the folder beside the log.

    Raises:
        LogFileError: there are none, or the log does not say when they were taken.

    """
    folder = folder or images_folder(flight)
    paths = tuple(sorted(folder.glob(IMAGES)))
    if not paths:
        raise LogFileError(
            f"{folder} holds no recorded images: fly with --record-frames, or give --frames FOLDER"
        )
    stamp_us = np.array([int(path.stem) for path in paths], dtype=np.int64)
    time_us = _log_times(flight, stamp_us)
    motion, attitude = flight.motion, flight.of_vehicle("ATTITUDE")
    angles = [attitude["roll"], attitude["pitch"], np.unwrap(attitude["yaw"])]
    turned = np.stack(angles, axis=1).astype(np.float64)
    return SeenImages(
        paths=paths,
        stamp_us=stamp_us,
        time_us=time_us,
        position_ned=interpolated(time_us, motion.time_us, motion.position_ned),
        velocity_ned=interpolated(time_us, motion.time_us, motion.velocity_ned),
        attitude_rad=interpolated(time_us, placed_us(attitude), turned),
        decision=_decided(flight, stamp_us),
        gates_passed=_passed(flight, time_us),
    )


def _log_times(flight: Flight, stamp_us: Numbers) -> Numbers:
    """Return when images were taken on the axis of the log, by the vehicle's clock."""
    for name in ("ATTITUDE", "LOCAL_POSITION_NED"):
        table = flight.of_vehicle(name)
        if len(table) > 1:
            clock_us = table["time_boot_ms"].astype(np.int64) * TOLD_MS
            offset_us = int(np.median(table.time_us - clock_us))
            return stamp_us + offset_us
    raise LogFileError(f"{flight.log.name} does not say when its images were taken: no ATTITUDE")


def _decided(flight: Flight, stamp_us: Numbers) -> Numbers:
    rows = {stamp: row for row, stamp in enumerate(flight.decisions.stamp_us.tolist())}
    found = [rows.get(stamp, UNDECIDED) for stamp in stamp_us.tolist()]
    return np.array(found, dtype=np.int64)


def _passed(flight: Flight, time_us: Numbers) -> Numbers:
    """Return how many gates the referee had counted at each time."""
    reached = flight.log["MISSION_ITEM_REACHED"].where(component=REFEREE_COMPONENT)
    _, first = np.unique(reached["seq"], return_index=True)
    counted = np.searchsorted(np.sort(reached.time_us[first]), time_us, side="right")
    return np.asarray(counted, dtype=np.int64)
