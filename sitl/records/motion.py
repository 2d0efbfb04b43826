"""Where the vehicle truly is and how it moves, and the types of vectors.

Frames: NED is the local frame (origin: the spawn point on the ground), FRD the body frame.
Quaternions are (w, x, y, z), Hamilton; `q_ned_frd` rotates an FRD vector into NED.
SI units and radians throughout; times are integer microseconds of vehicle time since boot.
"""

from typing import NamedTuple

Vector3 = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
MotorThrusts = tuple[float, float, float, float]  # fraction of each rotor's maximum thrust, 0..1


class VehicleState(NamedTuple):
    """The true rigid-body state at `time_us` (a NamedTuple, because one is made every tick)."""

    time_us: int
    position_ned: Vector3  # m
    velocity_ned: Vector3  # m/s
    q_ned_frd: Quaternion
    rates_frd: Vector3  # rad/s
    specific_force_frd: Vector3  # m/s2, what an ideal accelerometer reads
