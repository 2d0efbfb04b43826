"""Keep the home position: where the vehicle stood when it was armed, or where a command put it.

The heading that it stood in is kept beside the place: a return ends in it.
"""

import math
from typing import NamedTuple

from sitl.frames import yaw_of
from sitl.records.motion import Vector3
from sitl.records.sensing import Estimate

ORIGIN: Vector3 = (0.0, 0.0, 0.0)
CLEAR_M = 1.0  # above this the hover thrust is learnt, as PX4 does


class HomePlace(NamedTuple):
    """A place, and the heading that the vehicle stood in there."""

    known_ned: Vector3 | None = None
    yaw_rad: float = math.nan


class Home:
    """Where RTL leads to; unknown until there has been a position."""

    def __init__(self) -> None:
        self._place = HomePlace()

    def start_airborne(self) -> None:
        """Begin in the air, with the local origin as home."""
        self._place = HomePlace(ORIGIN, self._place.yaw_rad)

    @property
    def position_ned(self) -> Vector3:
        """The place, or the local origin while it is unknown."""
        return self._place.known_ned or ORIGIN

    @property
    def yaw_rad(self) -> float:
        """The heading in which a return ends; NaN: any."""
        return self._place.yaw_rad

    @property
    def known_ned(self) -> Vector3 | None:
        """The place, where it is known."""
        return self._place.known_ned

    def keep(self, estimate: Estimate, request: Vector3 | None, *, just_armed: bool) -> None:
        """Take a requested place (NaN: here), or the present one where it is time to."""
        is_due = estimate.position_valid and (just_armed or self._place.known_ned is None)
        if request is None and not is_due:
            return
        place = request or estimate.position_ned
        if math.isnan(place[0]):
            place = estimate.position_ned
        self._place = HomePlace(place, yaw_of(estimate.q_ned_frd))

    def is_clear_of_ground(self, estimate: Estimate) -> bool:
        """Whether the vehicle is well above home."""
        return self.position_ned[2] - estimate.position_ned[2] > CLEAR_M
