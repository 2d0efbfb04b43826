"""The barometer: static pressure of the standard atmosphere, with noise and an offset."""

import math
from typing import NamedTuple

import numpy as np

from sitl.sensors.noise import normals

RATE_HZ = 25
NOISE_STD_HPA = 0.01  # 1 Pa; source: PX4 src/modules/simulation/sensor_baro_sim
OFFSET_STD_HPA = 0.06  # assumption: half a metre, the day's weather after PX4 has set its reference
SEA_LEVEL_HPA = 1013.25  # International Standard Atmosphere, with the next three
SEA_LEVEL_C = 15.0
LAPSE_C_M = 0.0065
PRESSURE_EXPONENT = 5.25588


class BarometerReading(NamedTuple):
    """One sample."""

    pressure_hpa: float
    altitude_m: float  # AMSL, that the standard atmosphere has this pressure at
    temperature_c: float


NO_READING = BarometerReading(math.nan, math.nan, math.nan)  # before the first


class Barometer:
    """Reads the pressure at the vehicle's height."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._offset_hpa = float(rng.normal(0.0, OFFSET_STD_HPA))
        self._noise = normals(rng)

    def read(self, altitude_m: float) -> BarometerReading:
        """Sample now, at a true altitude AMSL."""
        pressure = pressure_hpa(altitude_m) + self._offset_hpa + NOISE_STD_HPA * next(self._noise)
        return BarometerReading(
            pressure, pressure_altitude_m(pressure), SEA_LEVEL_C - LAPSE_C_M * altitude_m
        )


def pressure_hpa(altitude_m: float) -> float:
    """Give the static pressure of the standard atmosphere (troposphere)."""
    ratio = 1.0 - LAPSE_C_M * altitude_m / (SEA_LEVEL_C + 273.15)
    return float(SEA_LEVEL_HPA * max(0.0, min(2.0, ratio)) ** PRESSURE_EXPONENT)


def pressure_altitude_m(pressure_hpa: float) -> float:
    """Give the altitude at which the standard atmosphere has a pressure."""
    ratio = (max(pressure_hpa, 1.0) / SEA_LEVEL_HPA) ** (1.0 / PRESSURE_EXPONENT)
    return float((1.0 - ratio) * (SEA_LEVEL_C + 273.15) / LAPSE_C_M)
