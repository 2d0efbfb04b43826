"""Read the setpoints that were sent, the camera images that they answer, and how late."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.columns.log import Log
from flightstack.logs.flight.vehicle import Interval, LoggedVehicle

LOCAL_NED, BODY_NED, BODY_FRD = 1, 8, 12  # MAV_FRAME
IGNORE_VELOCITY = 0b111 << 3  # bits of type_mask
IGNORE_YAW_RATE = 1 << 11
SETPOINT_MESSAGES = (
    "SET_POSITION_TARGET_LOCAL_NED",
    "SET_POSITION_TARGET_GLOBAL_INT",
    "SET_ATTITUDE_TARGET",
)
MAX_LATENCY_US = 5_000_000  # a stamp further off is of another clock

Floats = NDArray[np.float64]
Times = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class VelocitySetpoints:
    """Velocity setpoints in order of time."""

    time_us: Times  # when each was logged
    stamp_ms: Times  # time_boot_ms: for ours, the stamp of the image that it answers
    in_body: NDArray[np.bool_]  # body frame (yaw only), else north-east-down
    command: Floats  # (n, 4) vx, vy, vz m/s, yaw rate rad/s; NaN where ignored

    def __len__(self) -> int:
        return len(self.time_us)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Answers:
    """Camera images, and how late each was answered."""

    images: int  # of the camera while OFFBOARD
    answered: int
    time_us: Times  # of the answering setpoints
    latency_ms: Floats  # from the image to its setpoint, in the log's time

    @property
    def fraction(self) -> float:
        """Answered images over all."""
        return self.answered / self.images if self.images else 0.0


def within(times: Times, spans: list[Interval]) -> NDArray[np.bool_]:
    """Return which times fall into one of the spans."""
    inside = np.zeros(len(times), dtype=np.bool_)
    for span in spans:
        inside |= (times >= span.start_us) & (times < span.end_us)
    return inside


def setpoint_times(log: Log, vehicle: LoggedVehicle) -> Times:
    """Return when setpoints of any kind were sent to the vehicle."""
    log.load(SETPOINT_MESSAGES)
    times = []
    for name in SETPOINT_MESSAGES:
        table = log[name]
        times.append(table.time_us[np.isin(table["target_system"], (0, vehicle.system))])
    return np.sort(np.concatenate(times))


def _followed(log: Log, vehicle: LoggedVehicle) -> VelocitySetpoints:
    """Return the velocities that the vehicle's position controller followed, as it told them."""
    table = vehicle.sent(log, "POSITION_TARGET_LOCAL_NED")
    columns = [table[name].astype(np.float64) for name in ("vx", "vy", "vz", "yaw_rate")]
    return VelocitySetpoints(
        time_us=table.time_us,
        stamp_ms=table["time_boot_ms"].astype(np.int64),
        in_body=np.zeros(len(table), dtype=np.bool_),
        command=np.stack(columns, axis=1),
    )


def find_setpoints(log: Log, vehicle: LoggedVehicle) -> VelocitySetpoints:
    """Return the velocity setpoints that were sent to the vehicle.

    The vehicle's own log does not hold what was sent: there they are those that it followed.
    """
    if not log.is_telemetry:
        return _followed(log, vehicle)
    table = log["SET_POSITION_TARGET_LOCAL_NED"]
    mask = table["type_mask"]
    for_us = np.isin(table["target_system"], (0, vehicle.system))
    table = table.take(for_us & (mask & IGNORE_VELOCITY == 0))
    yaw_rate = np.where(table["type_mask"] & IGNORE_YAW_RATE, np.nan, table["yaw_rate"])
    columns = [table[name].astype(np.float64) for name in ("vx", "vy", "vz")]
    return VelocitySetpoints(
        time_us=table.time_us,
        stamp_ms=table["time_boot_ms"].astype(np.int64),
        in_body=np.isin(table["coordinate_frame"], (BODY_NED, BODY_FRD)),
        command=np.stack([*columns, yaw_rate.astype(np.float64)], axis=1),
    )


def _first_of_each(keys: Times) -> NDArray[np.intp]:
    """Return the first row of each key: an image triggered or answered twice counts once."""
    return np.unique(keys, return_index=True)[1]


def camera_answers(log: Log, setpoints: VelocitySetpoints, offboard: list[Interval]) -> Answers:
    """Match camera images with the setpoints that carry their stamp."""
    triggers = log["CAMERA_TRIGGER"]
    triggers = triggers.take(within(triggers.time_us, offboard))
    stamp_ms = (triggers["time_usec"] // 1000).astype(np.int64)
    first = _first_of_each(stamp_ms)
    stamp_ms, shot_us = stamp_ms[first], triggers.time_us[first]
    answer_rows = _first_of_each(setpoints.stamp_ms)
    common, image_rows, rows = np.intersect1d(
        stamp_ms, setpoints.stamp_ms[answer_rows], assume_unique=True, return_indices=True
    )
    answer_us = setpoints.time_us[answer_rows[rows]]
    return Answers(
        images=len(stamp_ms),
        answered=len(common),
        time_us=answer_us,
        latency_ms=np.multiply(answer_us - shot_us[image_rows], 1e-3, dtype=np.float64),
    )


def boot_offset_us(log: Log, vehicle: LoggedVehicle) -> int | None:
    """Return log time minus vehicle time: the smallest seen, that of the fastest datagram."""
    for name in ("ATTITUDE", "LOCAL_POSITION_NED", "ATTITUDE_QUATERNION"):
        table = vehicle.sent(log, name)
        if len(table):
            return int((table.time_us - table["time_boot_ms"].astype(np.int64) * 1000).min())
    return None


def stamp_latency_ms(setpoints: VelocitySetpoints, offset_us: int) -> Floats:
    """Return how old the stamp of each setpoint was when it was logged; NaN without a stamp."""
    latency_us = setpoints.time_us - setpoints.stamp_ms * 1000 - offset_us
    strange = np.abs(latency_us) > MAX_LATENCY_US
    return np.where(strange | (setpoints.stamp_ms == 0), np.nan, latency_us * 1e-3)
