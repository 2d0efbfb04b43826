"""Notice that somebody else steers the same vehicle, by what it follows and by who else beats."""

import math
from collections import deque
from collections.abc import Iterable, Mapping

from flightstack.companion.mission.records import MissionPhase
from flightstack.mavlink.offboard import Velocities
from flightstack.mavlink.telemetry import Telemetry
from flightstack.mavlink_numbers import COMPANION_COMPONENT
from flightstack.px4_modes import Px4Mode

REMEMBERED = 64  # setpoints: three seconds
SEEN_OFTEN = 3  # targets that are not ours, between two heartbeats
TOLERANCE = 0.1  # m/s, rad/s
CLIPPED_TO = 0.4  # of what was asked, where the vehicle's own limits are narrower
BEFORE_LIFTING = (MissionPhase.WAITING, MissionPhase.ARMING)


class OnePilot:
    """Compares the velocity that the vehicle follows with those that were sent to it.

    A target in local NED keeps the length of its horizontal part, its vertical part and its yaw
    rate, whichever way the vehicle heads. It counts only while two HEARTBEATs in a row say
    OFFBOARD: a mode that has just been left shows up to a second late.
    """

    def __init__(self) -> None:
        self._sent: deque[tuple[float, float, float]] = deque(maxlen=REMEMBERED)
        self._foreign = 0  # targets since the last heartbeat
        self._target_us: int | None = None
        self._heartbeat_us: int | None = None
        self._was_offboard = False
        self._has_other = False

    def note_setpoint(self, velocities: Velocities) -> None:
        """Remember what was sent."""
        forward, right, down, yaw_rate = velocities
        self._sent.append((math.hypot(forward, right), down, yaw_rate))

    def has_other(self, phase: MissionPhase, vehicle: Telemetry, others: Mapping[int, int]) -> bool:
        """Say whether somebody else steers the vehicle, or is about to."""
        if phase in BEFORE_LIFTING and COMPANION_COMPONENT in others:
            return True
        if phase is not MissionPhase.FLYING:
            self._foreign, self._was_offboard = 0, False
            return False
        self._compare(vehicle)
        self._judge_at_heartbeat(vehicle)
        return self._has_other

    def _compare(self, vehicle: Telemetry) -> None:
        if vehicle.target_us == self._target_us or len(self._sent) < REMEMBERED:
            return
        self._target_us = vehicle.target_us
        target = followed(vehicle)
        if target is not None and any(map(_is_foreign, target, zip(*self._sent, strict=True))):
            self._foreign += 1

    def _judge_at_heartbeat(self, vehicle: Telemetry) -> None:
        if vehicle.heartbeat_us == self._heartbeat_us:
            return
        self._heartbeat_us = vehicle.heartbeat_us
        is_offboard = vehicle.custom_mode == Px4Mode.OFFBOARD
        if is_offboard and self._was_offboard and self._foreign >= SEEN_OFTEN:
            self._has_other = True
        self._was_offboard, self._foreign = is_offboard, 0


def followed(vehicle: Telemetry) -> tuple[float, float, float] | None:
    """Return the horizontal speed, the vertical one and the yaw rate that are followed."""
    if vehicle.target_ned is None or vehicle.target_yaw_rate is None:
        return None
    north, east, down = vehicle.target_ned
    target = (math.hypot(north, east), down, vehicle.target_yaw_rate)
    return target if all(map(math.isfinite, target)) else None


def _is_foreign(value: float, sent: Iterable[float]) -> bool:
    """Whether a figure lies outside those that were sent, allowing for limits of the vehicle."""
    values = tuple(sent)
    low, high = min(values), max(values)
    low = low if low <= 0 else CLIPPED_TO * low
    high = high if high >= 0 else CLIPPED_TO * high
    return not low - TOLERANCE <= value <= high + TOLERANCE
