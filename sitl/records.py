"""The records that travel between the rooms of the simulator.

Frames: NED is the local frame (origin: the spawn point on the ground), FRD the body frame.
Quaternions are (w, x, y, z), Hamilton; `q_ned_frd` rotates an FRD vector into NED.
SI units and radians throughout; times are integer microseconds of vehicle time since boot.
"""

import math
from dataclasses import dataclass
from enum import StrEnum
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Vector3 = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
CRITICAL, WARNING, NOTICE, INFO = 2, 4, 5, 6  # MAV_SEVERITY of a StatusText
MotorThrusts = tuple[float, float, float, float]  # fraction of each rotor's maximum thrust, 0..1


class VehicleState(NamedTuple):
    """The true rigid-body state at `time_us` (a NamedTuple, because one is made every tick)."""

    time_us: int
    position_ned: Vector3  # m
    velocity_ned: Vector3  # m/s
    q_ned_frd: Quaternion
    rates_frd: Vector3  # rad/s
    specific_force_frd: Vector3  # m/s2, what an ideal accelerometer reads


class SensorHealth(NamedTuple):
    """Which sensors give readings that make sense."""

    gyro: bool = True
    accelerometer: bool = True
    magnetometer: bool = True
    barometer: bool = True
    gps: bool = True


class GpsReading(NamedTuple):
    """One fix of the satellite receiver, its position already in the local frame."""

    time_us: int
    position_ned: Vector3  # m
    velocity_ned: Vector3  # m/s
    fix_type: int  # GPS_FIX_TYPE
    satellites: int


class Readings(NamedTuple):
    """What each sensor read last, with its noise and bias."""

    rates_frd: Vector3  # rad/s
    specific_force_frd: Vector3  # m/s2
    field_frd: Vector3  # gauss
    pressure_hpa: float
    pressure_altitude_m: float  # AMSL, of the standard atmosphere
    temperature_c: float
    gps: GpsReading
    health: SensorHealth
    battery: float = 1.0  # charge left, 0..1
    battery_v: float = 16.2  # of the whole pack


class Estimate(NamedTuple):
    """What the autopilot believes; never the truth itself."""

    time_us: int
    position_ned: Vector3  # m
    velocity_ned: Vector3  # m/s
    q_ned_frd: Quaternion
    rates_frd: Vector3  # rad/s
    specific_force_frd: Vector3  # m/s2
    attitude_valid: bool
    position_valid: bool  # horizontal position and velocity
    altitude_valid: bool
    sensors: SensorHealth = SensorHealth()
    battery: float = 1.0  # charge left, 0..1
    accuracy_m: tuple[float, float] = (0.0, 0.0)  # standard deviation, horizontal and vertical
    settled: bool = True  # long enough after boot to take off by it
    z_deriv_m_s: float = math.nan  # rate of the estimated position, down; NaN: that is the velocity


NO_ESTIMATE = Estimate(
    time_us=0,
    position_ned=(0.0, 0.0, 0.0),
    velocity_ned=(0.0, 0.0, 0.0),
    q_ned_frd=(1.0, 0.0, 0.0, 0.0),
    rates_frd=(0.0, 0.0, 0.0),
    specific_force_frd=(0.0, 0.0, 0.0),
    attitude_valid=False,
    position_valid=False,
    altitude_valid=False,
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Gate:
    """One gate of a course: a square opening that is passed along its axis."""

    index: int
    centre_ned: Vector3  # m
    yaw_rad: float  # heading of the axis along which the gate is to be passed, NED


class FrameStamp(NamedTuple):
    """When an image was taken, and its number."""

    time_us: int
    sequence: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Frame:
    """One camera image."""

    time_us: int
    sequence: int
    rgb: NDArray[np.uint8]  # (H, W, 3)


@dataclass(frozen=True, slots=True, kw_only=True)
class StatusText:
    """A line for the pilot, with its MAV_SEVERITY."""

    severity: int
    text: str


class CourseState(StrEnum):
    """Where the course stands."""

    ACTIVE = "active"
    FINISHED = "finished"
    FAILED = "failed"


class CourseEventKind(StrEnum):
    """What the referee saw."""

    PASSED = "passed"
    MISSED = "missed"
    COLLISION = "collision"
    FINISHED = "finished"


@dataclass(frozen=True, slots=True, kw_only=True)
class CourseEvent:
    """One thing that the referee saw; `gate` counts from 0 over all laps."""

    kind: CourseEventKind
    gate: int
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class CourseStatus:
    """The score so far."""

    gates_passed: int
    gates_total: int
    state: CourseState
