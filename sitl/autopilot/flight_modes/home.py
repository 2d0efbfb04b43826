"""Keep the home position: where the vehicle stood when it was armed, or where a command put it.

The heading that it stood in is kept beside the place: a return ends in it.
"""

import math

from sitl.frames import yaw_of
from sitl.records.motion import Vector3
from sitl.records.sensing import Estimate

ORIGIN: Vector3 = (0.0, 0.0, 0.0)
CLEAR_M = 1.0  # above this the hover thrust is learnt, as PX4 does


class Home:
    """Where RTL leads to; unknown until there has been a position."""

    def __init__(self) -> None:
        self.known_ned: Vector3 | None = None
        self.yaw_rad = math.nan

    @property
    def position_ned(self) -> Vector3:
        """The place, or the local origin while it is unknown."""
        return self.known_ned or ORIGIN

    def keep(self, estimate: Estimate, request: Vector3 | None, *, just_armed: bool) -> None:
        """Take a requested place (NaN: here), or the present one where it is time to."""
        if request is not None:
            self.known_ned = estimate.position_ned if math.isnan(request[0]) else request
            self.yaw_rad = yaw_of(estimate.q_ned_frd)
        elif estimate.position_valid and (self.known_ned is None or just_armed):
            self.known_ned = estimate.position_ned
            self.yaw_rad = yaw_of(estimate.q_ned_frd)

    def is_clear_of_ground(self, estimate: Estimate) -> bool:
        """Whether the vehicle is well above home."""
        return self.position_ned[2] - estimate.position_ned[2] > CLEAR_M
