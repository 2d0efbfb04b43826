"""The magnetometer: the earth's field in the body frame, with noise and a bias from the seed."""

import numpy as np

from sitl.frames import rotate_inverse
from sitl.records.motion import Vector3, VehicleState
from sitl.sensors.noise import normal_vector, normals

RATE_HZ = 50
FIELD_NED = (0.215, 0.011, 0.433)  # gauss, World Magnetic Model at PX4's default home
NOISE_STD = (0.02, 0.02, 0.03)  # gauss; source: PX4 sensor_mag_sim/SensorMagSim.cpp
BIAS_STD = 0.005  # gauss; assumption: what a calibration leaves over


class Magnetometer:
    """Reads the field in gauss."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._bias = normal_vector(rng, BIAS_STD)
        self._noise = normals(rng)

    def read(self, state: VehicleState) -> Vector3:
        """Sample now, FRD."""
        x, y, z = rotate_inverse(state.q_ned_frd, FIELD_NED)
        (bx, by, bz), (sx, sy, sz), noise = self._bias, NOISE_STD, self._noise
        return (x + bx + sx * next(noise), y + by + sy * next(noise), z + bz + sz * next(noise))
