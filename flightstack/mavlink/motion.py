"""How the vehicle has moved, by telemetry: poses at the stamps of images, late ones too.

ATTITUDE and LOCAL_POSITION_NED come at their own times, each with its stamp; a pose between two is
interpolated, one after the newest carried on for a moment. What jumps back in time is of a vehicle
that has started anew: all before it is forgotten.
"""

import math
from collections import deque
from typing import NamedTuple

from flightstack.frames import wrap_pi
from flightstack.mavlink.link import Message
from flightstack.records import Pose

KEPT = 64  # of either: 2 s and more
MAX_AHEAD_US = 300_000  # beyond the newest message nobody knows
MAX_BACK_US = 1_000_000
MILLISECOND_US = 1000
SECOND_US = 1_000_000
Vector3 = tuple[float, float, float]
STILL = (0.0, 0.0, 0.0)


class _Attitude(NamedTuple):
    time_us: int
    angles: Vector3  # roll, pitch, yaw
    rates: Vector3


class _Place(NamedTuple):
    time_us: int
    position_ned: Vector3
    velocity_ned: Vector3


class MotionHistory:
    """The last seconds of attitude and position."""

    def __init__(self) -> None:
        self._attitudes: deque[_Attitude] = deque(maxlen=KEPT)
        self._places: deque[_Place] = deque(maxlen=KEPT)

    def forget(self) -> None:
        """Forget the motion of another vehicle."""
        self._attitudes.clear()
        self._places.clear()

    def note_attitude(self, message: Message) -> None:
        """Take ATTITUDE."""
        angles = (message.roll, message.pitch, message.yaw)
        rates = (message.rollspeed, message.pitchspeed, message.yawspeed)
        if _is_finite(*angles, *rates):
            entry = _Attitude(message.time_boot_ms * MILLISECOND_US, angles, rates)
            if _may_follow(self._attitudes, entry.time_us):
                self._attitudes.append(entry)

    def note_position(self, message: Message) -> None:
        """Take LOCAL_POSITION_NED."""
        position = (message.x, message.y, message.z)
        velocity = (message.vx, message.vy, message.vz)
        if _is_finite(*position, *velocity):
            entry = _Place(message.time_boot_ms * MILLISECOND_US, position, velocity)
            if _may_follow(self._places, entry.time_us):
                self._places.append(entry)

    def note(self, pose: Pose) -> None:
        """Take a pose that another history told: here it is known for that moment alone."""
        angles = (pose.roll_rad, pose.pitch_rad, pose.yaw_rad)
        attitude = _Attitude(pose.time_us, angles, STILL)
        if _may_follow(self._attitudes, pose.time_us):
            self._attitudes.append(attitude)
        if _may_follow(self._places, pose.time_us):
            self._places.append(_Place(pose.time_us, pose.position_ned, pose.velocity_ned))

    @property
    def latest(self) -> Pose | None:
        """Where the vehicle is, at the stamp of the newest attitude."""
        return self.at(self._attitudes[-1].time_us) if self._attitudes else None

    def at(self, time_us: int) -> Pose | None:
        """Where it was then; None where telemetry does not reach."""
        angles = _between_attitudes(self._attitudes, time_us)
        place = _between_places(self._places, time_us)
        if angles is None or place is None:
            return None
        roll, pitch, yaw = angles
        return Pose(
            time_us=time_us,
            position_ned=place.position_ned,
            velocity_ned=place.velocity_ned,
            roll_rad=roll,
            pitch_rad=pitch,
            yaw_rad=yaw,
        )

    def displacement_m_s(self, over_s: float) -> Vector3 | None:
        """Return how fast the position told has moved over the last moments; None at first."""
        if not self._places:
            return None
        newest = self._places[-1]
        since_us = newest.time_us - round(over_s * SECOND_US)
        before = _between_places(self._places, since_us)
        if before is None or before.time_us >= newest.time_us:
            return None
        elapsed_s = (newest.time_us - before.time_us) / SECOND_US
        north, east, down = (
            (now - then) / elapsed_s
            for now, then in zip(newest.position_ned, before.position_ned, strict=True)
        )
        return (north, east, down)


def _may_follow(entries: deque[_Attitude] | deque[_Place], time_us: int) -> bool:
    """Whether a message is newer than the last; forgets what was before a restart."""
    if not entries or time_us > entries[-1].time_us:
        return True
    if entries[-1].time_us - time_us > MAX_BACK_US:
        entries.clear()
        return True
    return False


def _between_attitudes(entries: deque[_Attitude], time_us: int) -> Vector3 | None:
    """Interpolate angles, each the short way; carry the newest on by its rates."""
    if not entries:
        return None
    newest = entries[-1]
    if time_us >= newest.time_us:
        ahead_s = _ahead_s(newest.time_us, time_us)
        if ahead_s is None:
            return None
        roll, pitch, yaw = newest.angles  # level flight: body rates are the angles' own
        return (roll, pitch, wrap_pi(yaw + newest.rates[2] * ahead_s))
    for after, before in zip(reversed(entries), list(reversed(entries))[1:], strict=False):
        if before.time_us <= time_us:
            share = (time_us - before.time_us) / (after.time_us - before.time_us)
            roll, pitch, yaw = (
                wrap_pi(one + share * wrap_pi(other - one))
                for one, other in zip(before.angles, after.angles, strict=True)
            )
            return (roll, pitch, yaw)
    return None


def _between_places(entries: deque[_Place], time_us: int) -> _Place | None:
    """Interpolate positions; carry the newest on by its velocity."""
    if not entries:
        return None
    newest = entries[-1]
    if time_us >= newest.time_us:
        ahead_s = _ahead_s(newest.time_us, time_us)
        return (
            None
            if ahead_s is None
            else _Place(
                time_us,
                _moved(newest.position_ned, newest.velocity_ned, ahead_s),
                newest.velocity_ned,
            )
        )
    for after, before in zip(reversed(entries), list(reversed(entries))[1:], strict=False):
        if before.time_us <= time_us:
            share = (time_us - before.time_us) / (after.time_us - before.time_us)
            return _Place(
                time_us,
                _mixed(before.position_ned, after.position_ned, share),
                _mixed(before.velocity_ned, after.velocity_ned, share),
            )
    return None


def _ahead_s(newest_us: int, time_us: int) -> float | None:
    ahead_us = time_us - newest_us
    return None if ahead_us > MAX_AHEAD_US else ahead_us / SECOND_US


def _moved(position: Vector3, velocity: Vector3, elapsed_s: float) -> Vector3:
    north, east, down = (p + v * elapsed_s for p, v in zip(position, velocity, strict=True))
    return (north, east, down)


def _mixed(one: Vector3, other: Vector3, share: float) -> Vector3:
    north, east, down = (a + share * (b - a) for a, b in zip(one, other, strict=True))
    return (north, east, down)


def _is_finite(*values: float) -> bool:
    return all(map(math.isfinite, values))
