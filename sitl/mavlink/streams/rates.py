"""Which messages a link sends how often: PX4's tables, and SET_MESSAGE_INTERVAL.

Rates in Hz. `NORMAL` and `ONBOARD` are the defaults of PX4's link modes; PX4's start script for
simulation raises some on the ground station's link. Left out is what this vehicle cannot fill:
open drone id, distance sensor, link statistics.
"""

import heapq
import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction

from sitl.clock import SECOND_US, Schedule
from sitl.mavlink.wire.dialect import mavlink
from sitl.mavlink.wire.newer_messages import CurrentEventSequence

HEARTBEAT = mavlink.MAVLINK_MSG_ID_HEARTBEAT
DISABLED_US = -1  # MESSAGE_INTERVAL
DEFAULT_US = 0  # SET_MESSAGE_INTERVAL
MAX_QUEUE = 256  # entries of changed rates stay until they would be due, or until this

Rates = Mapping[int, float]

NORMAL: Rates = {
    mavlink.MAVLINK_MSG_ID_HEARTBEAT: 1,
    mavlink.MAVLINK_MSG_ID_ATTITUDE: 15,
    mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION: 10,
    mavlink.MAVLINK_MSG_ID_ATTITUDE_TARGET: 2,
    mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED: 1,
    mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: 5,
    mavlink.MAVLINK_MSG_ID_POSITION_TARGET_LOCAL_NED: 1.5,
    mavlink.MAVLINK_MSG_ID_SERVO_OUTPUT_RAW: 1,
    mavlink.MAVLINK_MSG_ID_GPS_RAW_INT: 5,
    mavlink.MAVLINK_MSG_ID_VFR_HUD: 4,
    mavlink.MAVLINK_MSG_ID_ALTITUDE: 1,
    mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE: 1,
    mavlink.MAVLINK_MSG_ID_SYS_STATUS: 1,
    mavlink.MAVLINK_MSG_ID_MISSION_CURRENT: 1,
    mavlink.MAVLINK_MSG_ID_SCALED_PRESSURE: 1,
    mavlink.MAVLINK_MSG_ID_BATTERY_STATUS: 0.5,
    mavlink.MAVLINK_MSG_ID_HOME_POSITION: 0.5,
    mavlink.MAVLINK_MSG_ID_ESTIMATOR_STATUS: 0.5,
    mavlink.MAVLINK_MSG_ID_CURRENT_MODE: 0.5,
    CurrentEventSequence.id: 0.33,
    mavlink.MAVLINK_MSG_ID_PING: 0.1,
    mavlink.MAVLINK_MSG_ID_VIBRATION: 0.1,
}
SIMULATION_RAISES: Rates = {
    mavlink.MAVLINK_MSG_ID_ATTITUDE: 50,
    mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION: 50,
    mavlink.MAVLINK_MSG_ID_ATTITUDE_TARGET: 50,
    mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED: 50,
    mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: 50,
    mavlink.MAVLINK_MSG_ID_POSITION_TARGET_LOCAL_NED: 50,
    mavlink.MAVLINK_MSG_ID_SERVO_OUTPUT_RAW: 50,
}
ONBOARD: Rates = {
    mavlink.MAVLINK_MSG_ID_HEARTBEAT: 1,
    mavlink.MAVLINK_MSG_ID_ATTITUDE: 100,
    mavlink.MAVLINK_MSG_ID_ATTITUDE_QUATERNION: 50,
    mavlink.MAVLINK_MSG_ID_GLOBAL_POSITION_INT: 50,
    mavlink.MAVLINK_MSG_ID_HIGHRES_IMU: 50,
    mavlink.MAVLINK_MSG_ID_LOCAL_POSITION_NED: 30,
    mavlink.MAVLINK_MSG_ID_ODOMETRY: 30,
    mavlink.MAVLINK_MSG_ID_TIMESYNC: 10,
    mavlink.MAVLINK_MSG_ID_ALTITUDE: 10,
    mavlink.MAVLINK_MSG_ID_ATTITUDE_TARGET: 10,
    mavlink.MAVLINK_MSG_ID_POSITION_TARGET_LOCAL_NED: 10,
    mavlink.MAVLINK_MSG_ID_SERVO_OUTPUT_RAW: 10,
    mavlink.MAVLINK_MSG_ID_VFR_HUD: 10,
    mavlink.MAVLINK_MSG_ID_GPS_RAW_INT: 8,
    mavlink.MAVLINK_MSG_ID_EXTENDED_SYS_STATE: 5,
    mavlink.MAVLINK_MSG_ID_SYS_STATUS: 5,
    mavlink.MAVLINK_MSG_ID_ESTIMATOR_STATUS: 1,
    mavlink.MAVLINK_MSG_ID_PING: 1,
    mavlink.MAVLINK_MSG_ID_SCALED_PRESSURE: 1,
    mavlink.MAVLINK_MSG_ID_SYSTEM_TIME: 1,
    mavlink.MAVLINK_MSG_ID_MISSION_CURRENT: 1,
    mavlink.MAVLINK_MSG_ID_BATTERY_STATUS: 0.5,
    mavlink.MAVLINK_MSG_ID_HOME_POSITION: 0.5,
    mavlink.MAVLINK_MSG_ID_VIBRATION: 0.5,
    mavlink.MAVLINK_MSG_ID_CURRENT_MODE: 0.5,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Profile:
    """The rates of one kind of link."""

    default: Rates  # what interval 0 leads back to
    at_start: Rates


GROUND_STATION = Profile(default=NORMAL, at_start={**NORMAL, **SIMULATION_RAISES})
OFFBOARD_API = Profile(default=ONBOARD, at_start=ONBOARD)


@dataclass(slots=True, eq=False)
class _Stream:
    """Messages that are due together, always."""

    schedule: Schedule
    message_ids: set[int]


class StreamTable:
    """What one link sends when."""

    def __init__(self, profile: Profile) -> None:
        self._profile = profile
        self._streams: dict[int, _Stream] = {}
        self._intervals_us: dict[int, int] = {}
        self._queue: list[tuple[int, int, _Stream]] = []  # due time, tie-break
        self._entries = itertools.count()
        by_rate: dict[float, set[int]] = {}
        for message_id, rate_hz in profile.at_start.items():
            by_rate.setdefault(rate_hz, set()).add(message_id)
        for rate_hz, message_ids in by_rate.items():
            self._start(message_ids, round(SECOND_US / rate_hz), Schedule(rate_hz))

    def due(self, time_us: int) -> list[int]:
        """Say which messages to send now, in the order of their ids."""
        queue = self._queue
        due: list[int] = []
        while queue[0][0] <= time_us:
            _, entry, stream = queue[0]
            if not stream.message_ids:  # their rates were changed
                heapq.heappop(queue)
                continue
            stream.schedule.due(time_us)
            heapq.heapreplace(queue, (stream.schedule.next_due_us, entry, stream))
            due += stream.message_ids
        return sorted(due)

    def interval_us(self, message_id: int) -> int:
        """Say how often a message is sent, as MESSAGE_INTERVAL does: -1 for never."""
        return self._intervals_us.get(message_id, DISABLED_US)

    def set_interval(self, message_id: int, interval_us: int, time_us: int) -> bool:
        """Change a rate: 0 for the link's default, negative for never; refuses HEARTBEAT."""
        if message_id == HEARTBEAT:
            return False
        if interval_us == DEFAULT_US:
            rate_hz = self._profile.default.get(message_id)
            interval_us = DISABLED_US if rate_hz is None else round(SECOND_US / rate_hz)
        if message_id in self._streams:
            self._streams.pop(message_id).message_ids.remove(message_id)
        self._intervals_us.pop(message_id, None)
        if interval_us > 0:
            schedule = Schedule(Fraction(SECOND_US, interval_us), start_us=time_us)
            self._start({message_id}, interval_us, schedule)
        return True

    def _start(self, message_ids: set[int], interval_us: int, schedule: Schedule) -> None:
        stream = _Stream(schedule, message_ids)
        for message_id in message_ids:
            self._streams[message_id] = stream
            self._intervals_us[message_id] = interval_us
        if len(self._queue) >= MAX_QUEUE:
            self._queue = [entry for entry in self._queue if entry[2].message_ids]
            heapq.heapify(self._queue)
        heapq.heappush(self._queue, (schedule.next_due_us, next(self._entries), stream))
