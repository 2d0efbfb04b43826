"""Missions, fences and rally points as records: what the wire uploads and the autopilot flies."""

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

from sitl.records.mavlink_numbers import NOT_GIVEN


class PlanKind(IntEnum):
    """MAV_MISSION_TYPE: the three lists that a vehicle keeps."""

    MISSION = 0
    FENCE = 1
    RALLY = 2


class MissionResult(IntEnum):
    """MAV_MISSION_RESULT."""

    ACCEPTED = 0
    ERROR = 1
    UNSUPPORTED_FRAME = 2
    UNSUPPORTED = 3
    NO_SPACE = 4
    INVALID = 5
    INVALID_PARAM1 = 6
    INVALID_PARAM2 = 7
    INVALID_PARAM3 = 8
    INVALID_PARAM4 = 9
    INVALID_PARAM5_X = 10
    INVALID_PARAM6_Y = 11
    INVALID_PARAM7 = 12
    INVALID_SEQUENCE = 13
    DENIED = 14
    CANCELLED = 15


class MissionState(IntEnum):
    """MISSION_STATE, as MISSION_CURRENT shows it."""

    NO_MISSION = 1
    NOT_STARTED = 2
    ACTIVE = 3
    PAUSED = 4
    COMPLETE = 5


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionItem:
    """One item of a plan, with the numbers that were uploaded, so that they can be given back."""

    command: int  # MAV_CMD
    frame: int  # MAV_FRAME
    params: tuple[float, float, float, float]  # NaN where not given
    x: int  # latitude, deg * 1e7 where the frame is global
    y: int  # longitude, likewise
    z: float  # altitude, m: above mean sea level, or above home in a relative frame
    autocontinue: bool = True

    @property
    def latitude_deg(self) -> float:
        """Latitude; NaN where it is left to the vehicle."""
        return math.nan if self.x == NOT_GIVEN else self.x / 1e7

    @property
    def longitude_deg(self) -> float:
        """Longitude; NaN where it is left to the vehicle."""
        return math.nan if self.y == NOT_GIVEN else self.y / 1e7


Plan = tuple[MissionItem, ...]


class MissionProgress(NamedTuple):
    """How far the mission has come (a NamedTuple, because one is made every tick)."""

    sequence: int  # of the current item
    total: int
    state: MissionState
    in_mission_mode: bool
