"""All sensors of one vehicle: each samples at its own rate and keeps its last reading."""

import numpy as np

from sitl.clock import Schedule
from sitl.records.failures import FailureType, FailureUnit
from sitl.records.motion import Vector3, VehicleState
from sitl.records.sensing import GpsReading, Readings, SensorHealth
from sitl.sensors import barometer, gps, magnetometer
from sitl.sensors.barometer import pressure_altitude_m
from sitl.sensors.battery import Battery, Pack
from sitl.sensors.fault import Fault, Numbers
from sitl.sensors.imu import Imu
from sitl.sensors.noise import normals

HEALTHY = SensorHealth()
PACK = Pack(cells=4, full_v=4.05, empty_v=3.6, drain_s=60.0, min_charge=0.5)  # PX4's defaults
UNITS = (  # in the order of SensorHealth
    FailureUnit.GYRO,
    FailureUnit.ACCELEROMETER,
    FailureUnit.MAGNETOMETER,
    FailureUnit.BAROMETER,
    FailureUnit.GPS,
)
FAULT_SIZES = {  # how large garbage and a wrong offset are: plainly more than noise
    FailureUnit.GYRO: 0.3,  # rad/s
    FailureUnit.ACCELEROMETER: 3.0,  # m/s2
    FailureUnit.MAGNETOMETER: 0.3,  # gauss
    FailureUnit.BAROMETER: 5.0,  # hPa: 40 m
    FailureUnit.GPS: 30.0,  # m, m/s
    FailureUnit.BATTERY: 0.3,  # of the charge
}


class Sensors:
    """Samples the true state; every sensor draws from a stream of chance of its own."""

    def __init__(
        self, seed: list[int], *, altitude_m: float, rotor_noise_share: float = 1.0
    ) -> None:
        """Draw noise and biases from `seed`; `altitude_m` AMSL is that of the local origin."""
        chances = [np.random.default_rng([*seed, index]) for index in range(5)]
        self._altitude_m = altitude_m
        self.battery = Battery()
        self.imu = Imu(chances[0], rotor_noise_share=rotor_noise_share)
        self._gps = gps.Gps(chances[1])
        self._barometer = barometer.Barometer(chances[2])
        self._magnetometer = magnetometer.Magnetometer(chances[3])
        self._fault_noise = normals(chances[4])
        self._gps_schedule = Schedule(gps.RATE_HZ)
        self._barometer_schedule = Schedule(barometer.RATE_HZ)
        self._magnetometer_schedule = Schedule(magnetometer.RATE_HZ)
        self._faults: dict[FailureUnit, Fault] = {}
        self._health = HEALTHY
        self._charge = 1.0
        self._rates: Vector3 = (0.0, 0.0, 0.0)
        self._force: Vector3 = (0.0, 0.0, 0.0)
        self._field: Vector3 = magnetometer.FIELD_NED
        self._fix = gps.NO_READING
        self._air = barometer.NO_READING

    def fail(self, unit: FailureUnit, kind: FailureType, time_us: int) -> None:
        """Let a sensor fail from now on, or be well again."""
        self._faults.pop(unit, None)
        if kind is not FailureType.OK:
            self._faults[unit] = Fault(
                kind, size=FAULT_SIZES[unit], noise=self._fault_noise, time_us=time_us
            )
        self._health = self._judge(time_us)

    def update(self, state: VehicleState, pack: Pack = PACK, *, shaken: bool = False) -> Readings:
        """Sample what is due at the state's time; turning rotors shake the inertial unit."""
        time_us = state.time_us
        rates, force = self.imu.read(state, shaken=shaken)
        if self._faults:
            self._health = self._judge(time_us)
            rates = self._vector(FailureUnit.GYRO, rates, self._rates, time_us)
            force = self._vector(FailureUnit.ACCELEROMETER, force, self._force, time_us)
        self._rates, self._force = rates, force
        if self._gps_schedule.due(time_us):
            self._fix = self._sample_gps(state)
        if self._barometer_schedule.due(time_us):
            self._air = self._sample_air(state)
        if self._magnetometer_schedule.due(time_us):
            field = self._magnetometer.read(state)
            if self._faults:
                field = self._vector(FailureUnit.MAGNETOMETER, field, self._field, time_us)
            self._field = field
        charge = self.battery.remaining
        if self._faults:
            charge = self._read_charge(charge, time_us)
        self._charge = charge
        return Readings(
            rates,
            force,
            self._field,
            *self._air,
            self._fix,
            self._health,
            charge,
            pack.voltage_v(charge),
        )

    def _read_charge(self, charge: float, time_us: int) -> float:
        """Read the battery; a missing one counts as empty, as in PX4's simulator."""
        fault = self._faults.get(FailureUnit.BATTERY)
        return charge if fault is None else fault.share(charge, self._charge, time_us)

    def _sample_gps(self, state: VehicleState) -> GpsReading:
        fix = self._gps.read(state)
        if FailureUnit.GPS not in self._faults:
            return fix
        sample = (*fix.position_ned, *fix.velocity_ned)
        given = self._through(FailureUnit.GPS, sample, state.time_us)
        if given is None:
            if self._health.gps:  # stuck, slow or late: the last fix stands
                return self._fix
            return self._fix._replace(fix_type=gps.NO_FIX, satellites=0)
        x, y, z, vx, vy, vz = given
        return fix._replace(position_ned=(x, y, z), velocity_ned=(vx, vy, vz))

    def _sample_air(self, state: VehicleState) -> barometer.BarometerReading:
        air = self._barometer.read(self._altitude_m - state.position_ned[2])
        if FailureUnit.BAROMETER not in self._faults:
            return air
        given = self._through(FailureUnit.BAROMETER, (air.pressure_hpa,), state.time_us)
        if given is None:
            return self._air
        return air._replace(pressure_hpa=given[0], altitude_m=pressure_altitude_m(given[0]))

    def _vector(self, unit: FailureUnit, sample: Vector3, last: Vector3, time_us: int) -> Vector3:
        given = self._through(unit, sample, time_us)
        if given is None:
            return last
        x, y, z = given
        return (x, y, z)

    def _through(self, unit: FailureUnit, sample: Numbers, time_us: int) -> Numbers | None:
        fault = self._faults.get(unit)
        return sample if fault is None else fault.pass_on(sample, time_us)

    def _judge(self, time_us: int) -> SensorHealth:
        faults = self._faults
        if not faults:
            return HEALTHY
        return SensorHealth(
            *(unit not in faults or not faults[unit].is_detected(time_us) for unit in UNITS)
        )
