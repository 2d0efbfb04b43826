"""The satellite receiver: position and velocity, with white noise and a slow error."""

import math
from collections.abc import Iterator

import numpy as np

from sitl.records.motion import Vector3, VehicleState
from sitl.records.sensing import GpsReading
from sitl.sensors.noise import normal_vector, normals

RATE_HZ = 8  # as PX4's simulated receiver
FIX_3D, NO_FIX = 3, 0  # GPS_FIX_TYPE
SATELLITES = 10
# Per sample; source: PX4 src/modules/simulation/sensor_gps_sim/SensorGpsSim.cpp.
POSITION_STD_M = (0.2, 0.2, 0.5)
VELOCITY_STD_M_S = (0.06, 0.077, 0.158)
# Assumption: the slow part, by which a receiver that stands still is seen to wander.
SLOW_STD_M = 0.3
SLOW_TIME_CONSTANT_S = 60.0

NO_READING = GpsReading(
    0, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), NO_FIX, satellites=0
)  # before the first


class Gps:
    """Reads the true position and velocity at `RATE_HZ`."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._slow = normal_vector(rng, SLOW_STD_M)
        self._noise = normals(rng)
        self._decay = math.exp(-1.0 / (RATE_HZ * SLOW_TIME_CONSTANT_S))
        self._kick = SLOW_STD_M * math.sqrt(1.0 - self._decay**2)

    def read(self, state: VehicleState) -> GpsReading:
        """Sample now; to be called at `RATE_HZ`."""
        noise, decay, kick = self._noise, self._decay, self._kick
        x, y, z = self._slow
        self._slow = (
            decay * x + kick * next(noise),
            decay * y + kick * next(noise),
            decay * z + kick * next(noise),
        )
        return GpsReading(
            time_us=state.time_us,
            position_ned=_blur(_sum(state.position_ned, self._slow), POSITION_STD_M, noise),
            velocity_ned=_blur(state.velocity_ned, VELOCITY_STD_M_S, noise),
            fix_type=FIX_3D,
            satellites=SATELLITES,
        )


def _sum(a: Vector3, b: Vector3) -> Vector3:
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


def _blur(value: Vector3, std: Vector3, noise: Iterator[float]) -> Vector3:
    return (
        value[0] + std[0] * next(noise),
        value[1] + std[1] * next(noise),
        value[2] + std[2] * next(noise),
    )
