"""Follow a vehicle's clock, place and attitude over the pieces of a log."""

from dataclasses import fields, replace

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.columns.log import Log
from flightstack.logs.columns.table import Table
from flightstack.logs.flight.decisions import Decisions, find_decisions
from flightstack.mavlink_numbers import AUTOPILOT_COMPONENT

AUTOPILOT_INVALID = 8  # MAV_AUTOPILOT_INVALID: a companion, a camera, a ground station
KEPT_ROWS = 2000  # of each message: 20 s at the fastest rate
MILLISECOND = 1000  # us
MAX_US = 2**32 * MILLISECOND  # MAVLink counts vehicle time in 32 bits of milliseconds
REBOOT_US = 5_000_000  # a stamp further back than this is a new boot

Floats = NDArray[np.float64]
Numbers = NDArray[np.int64]


class FollowedTrack:
    """What is known of one vehicle so far. Times are us of vehicle time, since its boot."""

    def __init__(self, system: int | None = None) -> None:
        self.system = system  # of the first autopilot that is heard, where none is asked for
        self._offset_us: int | None = None  # log time minus vehicle time
        self._places = (np.empty(0, np.int64), np.empty((0, 6)))  # position, velocity NED
        self._angles = (np.empty(0, np.int64), np.empty((0, 3)))  # roll, pitch, yaw

    def learn(self, log: Log) -> None:
        """Take in the next piece."""
        if self.system is None:
            beats = log["HEARTBEAT"].where(component=AUTOPILOT_COMPONENT)
            systems = beats.system[beats["autopilot"] != AUTOPILOT_INVALID]
            self.system = int(systems[0]) if len(systems) else None
        places, angles = (
            self.of_vehicle(log, "LOCAL_POSITION_NED"),
            self.of_vehicle(log, "ATTITUDE"),
        )
        self._places = _joined(self._places, places, ("x", "y", "z", "vx", "vy", "vz"))
        self._angles = _joined(self._angles, angles, ("roll", "pitch", "yaw"))
        for table in (places, angles):
            if len(table):
                self._offset_us = int(np.median(table.time_us - boot_us(table)))

    def of_vehicle(self, log: Log, name: str) -> Table:
        """Return the messages of a type that the vehicle's autopilot sent."""
        system = -1 if self.system is None else self.system
        return log[name].where(system=system, component=AUTOPILOT_COMPONENT)

    def vehicle_us(self, time_us: Numbers) -> Numbers:
        """Return times of the log as vehicle time; before any is known, from the piece's start."""
        offset = self._offset_us
        if offset is None:
            offset = int(time_us[0]) if len(time_us) else 0
        return np.maximum(time_us - offset, 0)

    def motion_at(self, times_us: Numbers) -> tuple[Floats, Floats]:
        """Return positions and velocities NED at these times, (n, 3) m, m/s; NaN if unknown."""
        both = _interpolated(times_us, *self._places)
        return both[:, :3], both[:, 3:]

    def angles_at(self, times_us: Numbers) -> Floats:
        """Return roll, pitch and yaw at these times, (n, 3) rad; NaN where unknown."""
        return _interpolated(times_us, *self._angles)


def boot_us(table: Table) -> Numbers:
    """Return when the messages of a table were measured, us of vehicle time."""
    return np.asarray(table["time_boot_ms"].astype(np.int64) * MILLISECOND)


def sound_decisions(log: Log) -> Decisions:
    """Return the decisions whose stamps can be vehicle time; whoever speaks may say anything."""
    found = find_decisions(log)
    rows = (found.stamp_us >= 0) & (found.stamp_us < MAX_US)
    return replace(found, **{each.name: getattr(found, each.name)[rows] for each in fields(found)})


def _joined(
    known: tuple[Numbers, Floats], table: Table, names: tuple[str, ...]
) -> tuple[Numbers, Floats]:
    if not len(table):
        return known
    values = np.stack([table[name] for name in names], axis=1).astype(np.float64)
    new_us = boot_us(table)
    if len(known[0]) and new_us[0] < known[0][-1] - REBOOT_US:
        known = (known[0][:0], known[1][:0])  # the vehicle has restarted
    times = np.concatenate([known[0], new_us])
    rows = np.vstack([known[1], values])
    if "yaw" in names:
        rows[:, -1] = np.unwrap(rows[:, -1])
    keep = max(KEPT_ROWS, len(table))
    return times[-keep:], rows[-keep:]


def _interpolated(times_us: Numbers, known_us: Numbers, values: Floats) -> Floats:
    if not len(known_us):
        return np.full((len(times_us), values.shape[1]), np.nan)
    at, known = times_us.astype(np.float64), known_us.astype(np.float64)
    return np.stack([np.interp(at, known, column) for column in values.T], axis=1)
