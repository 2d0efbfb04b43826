"""The inertial unit: body rates and specific force, with noise and a bias from the seed."""

from typing import NamedTuple

import numpy as np

from sitl.records.motion import Vector3, VehicleState
from sitl.sensors.noise import normal_vector, normals

# Per sample at 250 Hz. Source: PX4-gazebo-models, models/x500_base/model.sdf.
GYRO_STD_RAD_S = (0.0008726646, 0.0008726646, 0.0008726646)
ACCELEROMETER_STD_M_S2 = (0.00637, 0.00637, 0.00686)
# The same while rotors turn and shake the unit, along FRD. Source: PX4's SIH, which has them from
# Bulka and Nahon, "Autonomous fixed-wing aerobatics: from theory to flight" (ICRA 2018).
SHAKEN_GYRO_STD_RAD_S = (0.14, 0.07, 0.03)
SHAKEN_ACCELEROMETER_STD_M_S2 = (0.5, 1.7, 1.4)
# Assumption: what a calibration leaves over; PX4 warns above 0.4 rad/s and 0.4 m/s2 per axis.
GYRO_BIAS_STD_RAD_S = 0.002
ACCELEROMETER_BIAS_STD_M_S2 = 0.02


class ImuReading(NamedTuple):
    """One sample in the body frame."""

    rates_frd: Vector3  # rad/s
    specific_force_frd: Vector3  # m/s2


class Imu:
    """Reads the true motion with noise and a bias that stays for the flight."""

    def __init__(self, rng: np.random.Generator, *, rotor_noise_share: float = 1.0) -> None:
        """Draw the biases; turning rotors add so much of their noise, never less than at rest."""
        share = rotor_noise_share
        self._shaken_gyro_std = _at_least(GYRO_STD_RAD_S, SHAKEN_GYRO_STD_RAD_S, share)
        self._shaken_accelerometer_std = _at_least(
            ACCELEROMETER_STD_M_S2, SHAKEN_ACCELEROMETER_STD_M_S2, share
        )
        self.gyro_bias_frd = normal_vector(rng, GYRO_BIAS_STD_RAD_S)
        self.accelerometer_bias_frd = normal_vector(rng, ACCELEROMETER_BIAS_STD_M_S2)
        self._noise = normals(rng)

    def read(self, state: VehicleState, *, shaken: bool = False) -> ImuReading:
        """Sample now; turning rotors shake the unit."""
        p, q, r = state.rates_frd
        fx, fy, fz = state.specific_force_frd
        bp, bq, br = self.gyro_bias_frd
        bx, by, bz = self.accelerometer_bias_frd
        sx, sy, sz = self._shaken_accelerometer_std if shaken else ACCELEROMETER_STD_M_S2
        sp, sq, sr = self._shaken_gyro_std if shaken else GYRO_STD_RAD_S
        noise = self._noise
        return ImuReading(
            (
                p + bp + sp * next(noise),
                q + bq + sq * next(noise),
                r + br + sr * next(noise),
            ),
            (
                fx + bx + sx * next(noise),
                fy + by + sy * next(noise),
                fz + bz + sz * next(noise),
            ),
        )


def _at_least(still: Vector3, shaken: Vector3, share: float) -> Vector3:
    x, y, z = (max(low, share * high) for low, high in zip(still, shaken, strict=True))
    return (x, y, z)
