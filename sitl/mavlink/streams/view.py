"""One moment of the vehicle, as its messages show it; derived figures are computed once."""

import math
from functools import cached_property

from sitl.frames import euler_from_quaternion, geodetic_from_ned
from sitl.mavlink.vehicle import SimulatedVehicle
from sitl.records.missions import MissionProgress
from sitl.records.motion import Vector3
from sitl.records.vehicle import SetpointEcho, VehicleStatus


class View:
    """What the encoders read. Belongs to one vehicle time; made anew for each."""

    def __init__(self, vehicle: SimulatedVehicle, *, unix_epoch_us: int = 0) -> None:
        self._autopilot = vehicle.autopilot
        self.time_us = vehicle.time_us
        self.time_ms = vehicle.time_us // 1000
        self.unix_us = unix_epoch_us + vehicle.time_us
        self.estimate = vehicle.estimate
        self.truth = vehicle.state
        self.readings = vehicle.readings

    @cached_property
    def status(self) -> VehicleStatus:
        """What the autopilot says about itself."""
        return self._autopilot.status

    @cached_property
    def setpoint(self) -> SetpointEcho:
        """What the controllers follow."""
        return self._autopilot.setpoint_echo

    @cached_property
    def euler_rad(self) -> Vector3:
        """Estimated roll, pitch, yaw."""
        return euler_from_quaternion(self.estimate.q_ned_frd)

    @property
    def mission(self) -> MissionProgress:
        """How far the mission has come."""
        return self._autopilot.missions.progress

    @property
    def heading_deg(self) -> float:
        """Estimated heading, 0..360."""
        return math.degrees(self.euler_rad[2]) % 360.0

    @cached_property
    def geodetic(self) -> Vector3:
        """Estimated latitude, longitude (deg), altitude AMSL (m)."""
        return geodetic_from_ned(self.estimate.position_ned, self.status.home)

    @cached_property
    def true_geodetic(self) -> Vector3:
        """True latitude, longitude (deg), altitude AMSL (m)."""
        return geodetic_from_ned(self.truth.position_ned, self.status.home)

    @property
    def height_above_home_m(self) -> float:
        """Estimated height above the home position."""
        return self.status.home_ned[2] - self.estimate.position_ned[2]


def saturate(value: float, low: int, high: int) -> int:
    """Round into an integer field; out of range and NaN stay at its ends."""
    return round(max(low, min(high, value)))


def int16(value: float) -> int:
    """Round into an int16 field."""
    return saturate(value, -(2**15), 2**15 - 1)


def uint16(value: float) -> int:
    """Round into a uint16 field whose largest value means "unknown"."""
    return saturate(value, 0, 2**16 - 2)


def int32(value: float) -> int:
    """Round into an int32 field."""
    return saturate(value, -(2**31), 2**31 - 1)


def degrees_e7(value_deg: float) -> int:
    """Latitude or longitude as the wire has it."""
    return int32(value_deg * 1e7)
