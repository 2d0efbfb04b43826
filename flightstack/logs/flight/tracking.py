"""Lay setpoints beside what the vehicle did: error, and the lag of the response.

Both are compared in the frame of the setpoints: body (turned by yaw alone, as PX4 does) or
north-east-down. The lag is the shift at which the response correlates best with the setpoint.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.columns.log import Log
from flightstack.logs.flight.motion import Motion, interpolated
from flightstack.logs.flight.setpoints import VelocitySetpoints, within
from flightstack.logs.flight.vehicle import Interval, LoggedVehicle

GRID_S = 0.02
MAX_LAG_S = 2.0
MIN_SPAN_S = 5.0  # less says nothing about a lag
MIN_CORRELATION = 0.5

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Tracking:
    """Setpoint and response at the times of the setpoints while OFFBOARD."""

    time_us: NDArray[np.int64]
    frame: str  # "body" or "NED"
    setpoint: Floats  # (n, 4) m/s, rad/s
    response: Floats  # (n, 4)

    def __len__(self) -> int:
        return len(self.time_us)

    def rms_error(self) -> Floats:
        """Return the root mean square of setpoint minus response, (4,); NaN where none."""
        if not len(self):
            return np.full(4, np.nan)
        square = np.square(self.setpoint - self.response)
        counts = np.isfinite(square).sum(axis=0)
        rms: Floats = np.sqrt(np.nansum(square, axis=0) / np.where(counts, counts, np.nan))
        return rms


def _response(log: Log, vehicle: LoggedVehicle, motion: Motion, times: NDArray[np.int64]) -> Floats:
    """Return velocity north, east, down, yaw rate and yaw at these times, (n, 5)."""
    attitude = vehicle.sent(log, "ATTITUDE")
    turning = np.stack([attitude["yawspeed"], np.unwrap(attitude["yaw"])], axis=1)
    velocity = interpolated(times, motion.time_us, motion.velocity_ned, outside=np.nan)
    turned = interpolated(times, attitude.time_us, turning.astype(np.float64), outside=np.nan)
    return np.hstack([velocity, turned])


def track(
    log: Log,
    vehicle: LoggedVehicle,
    motion: Motion,
    setpoints: VelocitySetpoints,
    offboard: list[Interval],
) -> Tracking:
    """Return setpoints and responses side by side, for the times in OFFBOARD."""
    rows = within(setpoints.time_us, offboard)
    in_body = bool(setpoints.in_body[rows].mean() >= 0.5) if rows.any() else True
    rows &= setpoints.in_body == in_body
    times = setpoints.time_us[rows]
    north, east, down, yaw_rate, yaw = _response(log, vehicle, motion, times).T
    if in_body:
        forward = np.cos(yaw) * north + np.sin(yaw) * east
        right = np.cos(yaw) * east - np.sin(yaw) * north
        response = np.stack([forward, right, down, yaw_rate], axis=1)
    else:
        response = np.stack([north, east, down, yaw_rate], axis=1)
    return Tracking(
        time_us=times,
        frame="body" if in_body else "NED",
        setpoint=setpoints.command[rows],
        response=response,
    )


def _correlations(a: Floats, b: Floats, max_shift: int) -> Floats:
    """Return the correlation of a[:-k] with b[k:] for k from 0 to max_shift."""
    found = np.zeros(max_shift + 1)
    for shift in range(max_shift + 1):
        left, right = a[: len(a) - shift], b[shift:]
        left, right = left - left.mean(), right - right.mean()
        norm = float(np.sqrt(np.square(left).sum() * np.square(right).sum()))
        shared = float((left * right).sum())  # not @, which wakes threads for less than they cost
        found[shift] = shared / norm if norm > 1e-9 else 0.0
    return found


def response_lag_s(tracking: Tracking, axis: int) -> float | None:
    """Return by how much the response follows the setpoint of one axis; None where unclear."""
    setpoint, response = tracking.setpoint[:, axis], tracking.response[:, axis]
    known = np.isfinite(setpoint) & np.isfinite(response)
    if known.sum() < 2:
        return None
    time_s = (tracking.time_us[known] - tracking.time_us[known][0]) * 1e-6
    if time_s[-1] < MIN_SPAN_S or np.ptp(setpoint[known]) < 1e-3:
        return None
    grid = np.arange(0.0, time_s[-1], GRID_S)
    place = np.clip(np.searchsorted(time_s, grid, side="right") - 1, 0, len(time_s) - 1)
    held = setpoint[known][place]  # a setpoint holds until the next
    followed = np.interp(grid, time_s, response[known])
    found = _correlations(held, followed, min(int(MAX_LAG_S / GRID_S), len(grid) // 2))
    best = int(found.argmax())
    return best * GRID_S if found[best] >= MIN_CORRELATION else None
