"""The way home: climb, fly back, descend, land.

CLIMB --height reached--> RETURN --over home--> DESCEND --RTL_DESCEND_ALT--> WAIT --delay--> LAND

The vehicle faces the way home, and as it stood there from the descent on. One that begins near
home turns so once it has climbed, and descends only then.
"""

import math
from enum import Enum

from sitl.autopilot.control.heading import FacingParameters
from sitl.autopilot.parameters import Parameters
from sitl.clock import SECOND_US
from sitl.records.motion import Vector3

NAN = math.nan


class Phase(Enum):
    """How far the return has come."""

    CLIMB = 1
    RETURN = 2
    DESCEND = 3
    WAIT = 4
    LAND = 5


class ReturnHome:
    """Keeps the phase of a return, and the height at which it leads."""

    def __init__(self, parameters: Parameters) -> None:
        self.height_m = 0.0  # above home
        self._phase = Phase.CLIMB
        self._home_ned: Vector3 = (0.0, 0.0, 0.0)
        self._home_yaw_rad = NAN
        self._begins_near = False
        self._waiting_since_us = 0
        self.load(parameters)

    def load(self, parameters: Parameters) -> None:
        """Take heights and distances from the parameters."""
        p = parameters
        self._return_height, self._descend_height = p["RTL_RETURN_ALT"], p["RTL_DESCEND_ALT"]
        self._near = p["RTL_MIN_DIST"]
        self._cone_rad = math.radians(p["RTL_CONE_ANG"])
        self._radius, self._altitude_radius = p["NAV_ACC_RAD"], p["NAV_MC_ALT_RAD"]
        self._delay_s = p["RTL_LAND_DELAY"]
        self._facing = FacingParameters.resolve(p.values)

    def start(self, position_ned: Vector3, home_ned: Vector3, home_yaw_rad: float = NAN) -> None:
        """Begin at a place; the heading to end in may be NaN: any."""
        self._home_ned, self._home_yaw_rad = home_ned, home_yaw_rad
        distance = math.hypot(position_ned[0] - home_ned[0], position_ned[1] - home_ned[1])
        self._begins_near = distance < self._near
        self.height_m = self._height(distance, home_ned[2] - position_ned[2])
        self._phase = Phase.CLIMB

    @property
    def yaw_rad(self) -> float:
        """The heading to turn to; NaN: the way of flying."""
        if self._phase is Phase.CLIMB or (self._phase is Phase.RETURN and not self._begins_near):
            return NAN
        return self._home_yaw_rad

    def update(self, time_us: int, position_ned: Vector3, yaw_rad: float) -> tuple[Phase, Vector3]:
        """Give the phase and its target; NaN: come to a stop."""
        home_x, home_y, home_z = self._home_ned
        distance = math.hypot(position_ned[0] - home_x, position_ned[1] - home_y)
        height = home_z - position_ned[2]
        low = min(self.height_m, self._descend_height)
        if self._phase is Phase.CLIMB and abs(height - self.height_m) < self._altitude_radius:
            self._phase = Phase.RETURN
        elif self._phase is Phase.RETURN and distance < self._radius and self._faces(yaw_rad):
            self._phase = Phase.DESCEND
        elif self._phase is Phase.DESCEND and height - low < self._altitude_radius:
            self._phase, self._waiting_since_us = Phase.WAIT, time_us
        elif self._phase is Phase.WAIT and self._waited(time_us):
            self._phase = Phase.LAND
        if self._phase is Phase.CLIMB:
            return self._phase, (NAN, NAN, home_z - self.height_m)
        if self._phase is Phase.RETURN:
            return self._phase, (home_x, home_y, home_z - self.height_m)
        return self._phase, (home_x, home_y, home_z - low)

    def _faces(self, yaw_rad: float) -> bool:
        """Whether the heading is the one to turn to, if there is one to wait for."""
        return self._facing.accepts(self.yaw_rad, yaw_rad)

    def _waited(self, time_us: int) -> bool:
        return 0.0 <= self._delay_s <= (time_us - self._waiting_since_us) / SECOND_US

    def _height(self, distance_m: float, height_m: float) -> float:
        """Height above home to return at: lower within a cone above home, never a descent."""
        if distance_m <= self._radius:
            return height_m
        wanted = self._return_height
        if distance_m <= self._near and self._cone_rad > 0.0:
            cone = distance_m / math.tan(self._cone_rad)
            wanted = min(max(cone, 2.0 * self._radius), self._return_height)
        return max(height_m, wanted)
