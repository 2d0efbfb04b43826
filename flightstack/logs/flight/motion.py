"""Where the vehicle was and how fast: from whichever position message the log holds."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.columns.log import Log
from flightstack.logs.columns.time_axis import measured_us, placed_us
from flightstack.logs.flight.vehicle import LoggedVehicle

EARTH_RADIUS_M = 6_371_000.0
MAX_STEP_S = 2.0  # a longer one, of a log that is faster elsewhere, is a gap
STANDING_M_S = 0.3  # slower than this is noise of the estimate, not a way flown

Floats = NDArray[np.float64]


def interpolated(
    times: NDArray[np.int64],
    known_at: NDArray[np.int64],
    values: Floats,
    outside: float | None = None,
) -> Floats:
    """Return values at times, each column linearly; beyond what is known `outside`, or the ends."""
    if not len(known_at):
        return np.full((len(times), values.shape[1]), np.nan)
    base = int(known_at[0])
    x, known = (times - base).astype(np.float64), (known_at - base).astype(np.float64)
    columns = [np.interp(x, known, column, left=outside, right=outside) for column in values.T]
    return np.stack(columns, axis=1)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Motion:
    """Position and velocity over time, in a local north-east-down frame."""

    source: str  # the message that it comes from
    time_us: NDArray[np.int64]  # on the axis of the log
    measured_us: NDArray[np.int64]  # by the vehicle's clock, for steps and derivatives
    position_ned: Floats  # (n, 3) m
    velocity_ned: Floats  # (n, 3) m/s

    def __len__(self) -> int:
        return len(self.time_us)

    @property
    def speed_m_s(self) -> Floats:
        """Length of the velocity."""
        return np.asarray(np.linalg.norm(self.velocity_ned, axis=1), dtype=np.float64)

    @property
    def horizontal_speed_m_s(self) -> Floats:
        """Length of the horizontal velocity."""
        return np.asarray(np.linalg.norm(self.velocity_ned[:, :2], axis=1), dtype=np.float64)

    def distance_m(self) -> float:
        """Length of the way flown: the integral of the speed where the vehicle really moves."""
        if len(self) < 2:
            return 0.0
        step_s = np.diff(self.measured_us) * 1e-6
        speed = self.speed_m_s[1:]
        longest_s = max(MAX_STEP_S, 3 * float(np.median(step_s)))
        counted = (step_s > 0) & (step_s < longest_s) & (speed > STANDING_M_S)
        return float((speed * step_s)[counted].sum())

    def within(self, start_us: int, end_us: int) -> "Motion":
        """Return the part between two times."""
        return self.take((self.time_us >= start_us) & (self.time_us < end_us))

    def take(self, rows: NDArray[np.bool_]) -> "Motion":
        """Return the part of these rows."""
        return Motion(
            source=self.source,
            time_us=self.time_us[rows],
            measured_us=self.measured_us[rows],
            position_ned=self.position_ned[rows],
            velocity_ned=self.velocity_ned[rows],
        )


def _local(log: Log, vehicle: LoggedVehicle) -> Motion:
    table = vehicle.sent(log, "LOCAL_POSITION_NED")
    return Motion(
        source=table.name,
        time_us=placed_us(table),
        measured_us=measured_us(table),
        position_ned=np.stack([table[axis] for axis in ("x", "y", "z")], axis=1).astype(np.float64),
        velocity_ned=np.stack([table[a] for a in ("vx", "vy", "vz")], axis=1).astype(np.float64),
    )


def _from_degrees(lat: Floats, lon: Floats) -> tuple[Floats, Floats]:
    """Return metres north and east of the first of these places, in degrees."""
    lat, lon = np.radians(lat), np.radians(lon)
    lat0, lon0 = (float(lat[0]), float(lon[0])) if len(lat) else (0.0, 0.0)
    north = (lat - lat0) * EARTH_RADIUS_M
    east = (lon - lon0) * EARTH_RADIUS_M * np.cos(lat0)
    return north, east


def _global(log: Log, vehicle: LoggedVehicle) -> Motion:
    table = vehicle.sent(log, "GLOBAL_POSITION_INT")
    has_fix = (table["lat"] != 0) | (table["lon"] != 0)
    table = table.take(has_fix)
    north, east = _from_degrees(table["lat"] * 1e-7, table["lon"] * 1e-7)
    altitude = table["relative_alt"] * 1e-3
    velocity = np.stack([table[a] for a in ("vx", "vy", "vz")], axis=1) * 0.01
    return Motion(
        source=table.name,
        time_us=placed_us(table),
        measured_us=measured_us(table),
        position_ned=np.stack([north, east, -altitude], axis=1),
        velocity_ned=velocity,
    )


def _high_latency(log: Log, vehicle: LoggedVehicle) -> Motion:
    """Return the motion of a vehicle on a narrow link; its height is above sea level."""
    table = vehicle.sent(log, "HIGH_LATENCY2")
    north, east = _from_degrees(table["latitude"] * 1e-7, table["longitude"] * 1e-7)
    heading = np.radians(table["heading"] * 2.0)
    speed = table["groundspeed"] * 0.2
    velocity = [np.cos(heading) * speed, np.sin(heading) * speed, table["climb_rate"] * -0.1]
    return Motion(
        source=table.name,
        time_us=table.time_us,
        measured_us=measured_us(table),
        position_ned=np.stack([north, east, table["altitude"] * -1.0], axis=1),
        velocity_ned=np.stack(velocity, axis=1),
    )


def find_motion(log: Log, vehicle: LoggedVehicle) -> Motion:
    """Return the vehicle's motion, local if logged, else from the global position."""
    for found in (_local, _global, _high_latency):
        motion = found(log, vehicle)
        known = np.asarray(np.isfinite(motion.position_ned).all(axis=1), dtype=np.bool_)
        if known.any():
            return motion if known.all() else motion.take(known)
    return motion
