"""The records through which the world talks to the autopilot, and the autopilot to the world."""

import math
from dataclasses import dataclass
from math import isnan
from typing import NamedTuple

from sitl.records.modes import Mode
from sitl.records.motion import Quaternion, Vector3

NAN_VECTOR: Vector3 = (math.nan, math.nan, math.nan)
IDENTITY: Quaternion = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Command:
    """A COMMAND_LONG or COMMAND_INT, x and y of the latter already in degrees."""

    command: int  # MAV_CMD
    params: tuple[float, float, float, float, float, float, float]  # NaN where not given
    frame: int = 0  # MAV_FRAME of a COMMAND_INT; 0 (GLOBAL, AMSL) for a COMMAND_LONG


@dataclass(frozen=True, slots=True, kw_only=True)
class CommandResult:
    """The answer to a command; where there is none, PX4 stays silent."""

    result: int  # MAV_RESULT


@dataclass(frozen=True, slots=True, kw_only=True)
class OffboardSetpoint:
    """One offboard setpoint in local NED; NaN means that the sender leaves it to the vehicle.

    A setpoint in the body frame is turned into NED by the vehicle's heading when it is received.
    """

    time_us: int  # vehicle time of reception
    position_ned: Vector3 = NAN_VECTOR  # m
    velocity_ned: Vector3 = NAN_VECTOR  # m/s
    acceleration_ned: Vector3 = NAN_VECTOR  # m/s2
    yaw_rad: float = math.nan
    yaw_rate_rad_s: float = math.nan


@dataclass(frozen=True, slots=True, kw_only=True)
class AttitudeTarget:
    """An offboard setpoint for the attitude, or for the body rates, with a thrust."""

    time_us: int  # vehicle time of reception
    q_ned_frd: Quaternion | None  # none: the rates alone count
    rates_frd: Vector3  # rad/s; beside an attitude only the yaw rate counts, as feed-forward
    thrust: float  # 0..1, collective


@dataclass(frozen=True, slots=True, kw_only=True)
class Sticks:
    """The sticks' positions, -1..1."""

    time_us: int  # vehicle time of reception
    forward: float
    right: float
    up: float  # 0 holds the height
    turn: float  # to the right


class SetpointEcho(NamedTuple):
    """What the controller follows now: POSITION_TARGET_LOCAL_NED and ATTITUDE_TARGET."""

    time_us: int
    position_ned: Vector3  # m, NaN where not controlled
    velocity_ned: Vector3  # m/s, NaN where not controlled
    acceleration_ned: Vector3  # m/s2
    yaw_rad: float
    yaw_rate_rad_s: float
    q_ned_frd: Quaternion  # attitude setpoint
    rates_frd: Vector3  # rad/s, body rate setpoint
    thrust: float  # 0..1, collective

    @property
    def type_mask(self) -> int:
        """POSITION_TARGET_TYPEMASK: a bit for each number that is NaN."""
        (x, y, z), (vx, vy, vz) = self.position_ned, self.velocity_ned
        ax, ay, az = self.acceleration_ned
        return (
            isnan(x)
            | isnan(y) << 1
            | isnan(z) << 2
            | isnan(vx) << 3
            | isnan(vy) << 4
            | isnan(vz) << 5
            | isnan(ax) << 6
            | isnan(ay) << 7
            | isnan(az) << 8  # bit 9 is the FORCE flag
            | isnan(self.yaw_rad) << 10
            | isnan(self.yaw_rate_rad_s) << 11
        )


class VehicleStatus(NamedTuple):
    """What the autopilot tells the world about itself."""

    time_us: int
    mode: Mode  # what it does
    intended_mode: Mode  # what the user asked for: differs in a failsafe
    custom_mode: int  # HEARTBEAT, of `mode`
    base_mode: int  # HEARTBEAT
    system_status: int  # MAV_STATE
    armed: bool
    armable: bool  # all checks pass in this mode: SYS_STATUS pre-arm bit
    failsafe: bool
    landed_state: int  # MAV_LANDED_STATE
    home: Vector3  # latitude deg, longitude deg, altitude m AMSL, of the local origin
    home_ned: Vector3  # m, where RTL leads to, local
    home_valid: bool
    attitude_valid: bool
    position_valid: bool
    altitude_valid: bool
    throttle: float  # 0..1, collective
    actuator_outputs: tuple[int, int, int, int]  # us, as SERVO_OUTPUT_RAW: 900 when disarmed
    battery_warning: int = 0  # 0 fine, 1 low, 2 critical, 3 emergency
