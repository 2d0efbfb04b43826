"""The way home: climb, fly back, descend, land.

CLIMB --height reached--> RETURN --over home--> DESCEND --RTL_DESCEND_ALT--> WAIT --delay--> LAND

The vehicle faces the way home, and as it stood there from the descent on. One that begins near
home turns so once it has climbed, and descends only then.
"""

import math
from enum import Enum
from typing import NamedTuple, Self

from sitl.autopilot.control.heading import FacingParameters
from sitl.autopilot.parameters import ParameterValues
from sitl.clock import SECOND_US
from sitl.records.motion import Vector3

NAN = math.nan


class ReturnPhase(Enum):
    """How far the return has come: one after another."""

    CLIMB = 1
    RETURN = 2
    DESCEND = 3
    WAIT = 4
    LAND = 5


class ReturnParameters(NamedTuple):
    """How high a return leads, and what it counts as arrived."""

    return_height_m: float  # RTL_RETURN_ALT
    descend_height_m: float  # RTL_DESCEND_ALT
    near_m: float  # RTL_MIN_DIST
    cone_rad: float  # RTL_CONE_ANG
    radius_m: float  # NAV_ACC_RAD
    altitude_radius_m: float  # NAV_MC_ALT_RAD
    delay_s: float  # RTL_LAND_DELAY; below 0: never land
    facing: FacingParameters

    @classmethod
    def resolve(cls, values: ParameterValues) -> Self:
        """Take PX4's values, in SI units."""
        return cls(
            return_height_m=values["RTL_RETURN_ALT"],
            descend_height_m=values["RTL_DESCEND_ALT"],
            near_m=values["RTL_MIN_DIST"],
            cone_rad=math.radians(values["RTL_CONE_ANG"]),
            radius_m=values["NAV_ACC_RAD"],
            altitude_radius_m=values["NAV_MC_ALT_RAD"],
            delay_s=values["RTL_LAND_DELAY"],
            facing=FacingParameters.resolve(values),
        )

    def height_for(self, distance_m: float, height_m: float) -> float:
        """Height above home to return at: lower within a cone above home, never a descent."""
        if distance_m <= self.radius_m:
            return height_m
        wanted = self.return_height_m
        if distance_m <= self.near_m and self.cone_rad > 0.0:
            cone = distance_m / math.tan(self.cone_rad)
            wanted = min(max(cone, 2.0 * self.radius_m), self.return_height_m)
        return max(height_m, wanted)


class ReturnHome(NamedTuple):
    """The phase of a return, and where it leads."""

    phase: ReturnPhase = ReturnPhase.CLIMB
    home_ned: Vector3 = (0.0, 0.0, 0.0)
    height_m: float = 0.0  # to fly back at, above home
    home_yaw_rad: float = NAN  # the heading to end in; NaN: any
    begins_near: bool = False
    since_us: int = 0  # when the phase began; not kept of the first

    @classmethod
    def start(
        cls,
        position_ned: Vector3,
        home_ned: Vector3,
        home_yaw_rad: float,
        parameters: ReturnParameters,
    ) -> Self:
        """Begin at a place."""
        distance = math.hypot(position_ned[0] - home_ned[0], position_ned[1] - home_ned[1])
        return cls(
            home_ned=home_ned,
            height_m=parameters.height_for(distance, home_ned[2] - position_ned[2]),
            home_yaw_rad=home_yaw_rad,
            begins_near=distance < parameters.near_m,
        )

    @property
    def yaw_rad(self) -> float:
        """The heading to turn to; NaN: the way of flying."""
        phase = self.phase
        if phase is ReturnPhase.CLIMB or (phase is ReturnPhase.RETURN and not self.begins_near):
            return NAN
        return self.home_yaw_rad

    def target_ned(self, parameters: ReturnParameters) -> Vector3:
        """Where to fly now; NaN: come to a stop."""
        home_x, home_y, home_z = self.home_ned
        if self.phase is ReturnPhase.CLIMB:
            return (NAN, NAN, home_z - self.height_m)
        if self.phase is ReturnPhase.RETURN:
            return (home_x, home_y, home_z - self.height_m)
        return (home_x, home_y, home_z - min(self.height_m, parameters.descend_height_m))

    def advance(
        self, time_us: int, position_ned: Vector3, yaw_rad: float, parameters: ReturnParameters
    ) -> "ReturnHome":
        """Go on to the next phase, where it is time to."""
        if not self._is_done(time_us, position_ned, yaw_rad, parameters):
            return self
        return self._replace(phase=ReturnPhase(self.phase.value + 1), since_us=time_us)

    def _is_done(
        self, time_us: int, position_ned: Vector3, yaw_rad: float, parameters: ReturnParameters
    ) -> bool:
        """Whether the phase has come to its end."""
        phase, (home_x, home_y, home_z) = self.phase, self.home_ned
        height, near = home_z - position_ned[2], parameters.altitude_radius_m
        if phase is ReturnPhase.CLIMB:
            return abs(height - self.height_m) < near
        if phase is ReturnPhase.RETURN:
            distance = math.hypot(position_ned[0] - home_x, position_ned[1] - home_y)
            faces = parameters.facing.accepts(self.yaw_rad, yaw_rad)
            return distance < parameters.radius_m and faces
        if phase is ReturnPhase.DESCEND:
            return height - min(self.height_m, parameters.descend_height_m) < near
        if phase is ReturnPhase.WAIT:
            return 0.0 <= parameters.delay_s <= (time_us - self.since_us) / SECOND_US
        return False
