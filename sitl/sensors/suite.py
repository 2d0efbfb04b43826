"""All sensors of one vehicle: each samples at its own rate and keeps its last reading."""

import numpy as np

from sitl.clock import Schedule
from sitl.records import Readings, SensorHealth, VehicleState
from sitl.sensors import barometer, gps, magnetometer
from sitl.sensors.battery import Battery, Pack
from sitl.sensors.imu import Imu

HEALTHY = SensorHealth()
PACK = Pack(cells=4, full_v=4.05, empty_v=3.6, drain_s=60.0, least=0.5)  # PX4's defaults


class Sensors:
    """Samples the true state; every sensor draws from a stream of chance of its own."""

    def __init__(self, seed: list[int], *, altitude_m: float) -> None:
        """Draw noise and biases from `seed`; `altitude_m` AMSL is that of the local origin."""
        chances = [np.random.default_rng([*seed, index]) for index in range(4)]
        self._altitude_m = altitude_m
        self.battery = Battery()
        self.imu = Imu(chances[0])
        self._gps = gps.Gps(chances[1])
        self._barometer = barometer.Barometer(chances[2])
        self._magnetometer = magnetometer.Magnetometer(chances[3])
        self._gps_schedule = Schedule(gps.RATE_HZ)
        self._barometer_schedule = Schedule(barometer.RATE_HZ)
        self._magnetometer_schedule = Schedule(magnetometer.RATE_HZ)

    def update(self, state: VehicleState, pack: Pack = PACK) -> Readings:
        """Sample what is due at the state's time."""
        time_us = state.time_us
        if self._gps_schedule.due(time_us):
            self._fix = self._gps.read(state)
        if self._barometer_schedule.due(time_us):
            self._air = self._barometer.read(self._altitude_m - state.position_ned[2])
        if self._magnetometer_schedule.due(time_us):
            self._field = self._magnetometer.read(state)
        battery = self.battery
        return Readings(
            *self.imu.read(state),
            self._field,
            *self._air,
            self._fix,
            HEALTHY,
            battery.remaining,
            battery.voltage_v(pack),
        )
