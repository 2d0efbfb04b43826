"""Each sensor reads the truth with the noise that its figures say, and the same for one seed."""

import math

import numpy as np
import pytest

from sitl.frames import quaternion_from_euler, rotate
from sitl.records.motion import VehicleState
from sitl.sensors import barometer, gps, imu, magnetometer
from sitl.sensors.suite import Sensors

STATE = VehicleState(
    time_us=0,
    position_ned=(10.0, -20.0, -5.0),
    velocity_ned=(1.0, -2.0, 0.5),
    q_ned_frd=quaternion_from_euler(0.1, -0.2, 2.0),
    rates_frd=(0.1, 0.2, -0.3),
    specific_force_frd=(0.5, -0.4, -9.8),
)
COUNT = 4000
FIVE_SIGMA = 5.0 / math.sqrt(2 * COUNT)  # relative, of a standard deviation from COUNT samples


def rng(seed: int = 3) -> np.random.Generator:
    return np.random.default_rng(seed)


def spread(samples: list[tuple[float, float, float]]) -> tuple[np.ndarray, np.ndarray]:
    table = np.array(samples)
    return table.mean(axis=0), table.std(axis=0)


def test_inertial_unit_has_noise_and_a_bias() -> None:
    unit = imu.Imu(rng())
    readings = [unit.read(STATE) for _ in range(COUNT)]
    mean, std = spread([reading.rates_frd for reading in readings])
    assert std == pytest.approx(imu.GYRO_STD_RAD_S, rel=FIVE_SIGMA)
    assert mean == pytest.approx(np.add(STATE.rates_frd, unit.gyro_bias_frd), abs=1e-4)
    mean, std = spread([reading.specific_force_frd for reading in readings])
    assert std == pytest.approx(imu.ACCELEROMETER_STD_M_S2, rel=FIVE_SIGMA)
    expected = np.add(STATE.specific_force_frd, unit.accelerometer_bias_frd)
    assert mean == pytest.approx(expected, abs=1e-3)
    assert 0.0 < max(map(abs, unit.gyro_bias_frd)) < 5 * imu.GYRO_BIAS_STD_RAD_S


def test_turning_rotors_shake_the_inertial_unit() -> None:
    unit = imu.Imu(rng())
    readings = [unit.read(STATE, shaken=True) for _ in range(COUNT)]
    _, std = spread([reading.rates_frd for reading in readings])
    assert std == pytest.approx(imu.SHAKEN_GYRO_STD_RAD_S, rel=FIVE_SIGMA)
    _, std = spread([reading.specific_force_frd for reading in readings])
    assert std == pytest.approx(imu.SHAKEN_ACCELEROMETER_STD_M_S2, rel=FIVE_SIGMA)


def test_receiver_has_white_velocity_noise_and_a_wandering_position() -> None:
    receiver = gps.Gps(rng())
    readings = [receiver.read(STATE) for _ in range(COUNT)]
    mean, std = spread([reading.velocity_ned for reading in readings])
    assert mean == pytest.approx(STATE.velocity_ned, abs=0.02)
    assert std == pytest.approx(gps.VELOCITY_STD_M_S, rel=FIVE_SIGMA)
    errors = np.array([reading.position_ned for reading in readings]) - STATE.position_ned
    steps = np.diff(errors, axis=0).std(axis=0) / math.sqrt(2.0)
    assert steps == pytest.approx(gps.POSITION_STD_M, rel=0.1)  # white from fix to fix
    minute = errors.reshape(-1, 80, 3).mean(axis=1).std(axis=0)  # slow over 10 s means
    assert (minute > 0.1).all()
    assert (minute < 0.6).all()


def test_barometer_reads_the_standard_atmosphere() -> None:
    assert barometer.pressure_hpa(0.0) == pytest.approx(1013.25)
    assert barometer.pressure_hpa(1000.0) == pytest.approx(898.75, abs=0.05)
    assert barometer.pressure_altitude_m(barometer.pressure_hpa(489.4)) == pytest.approx(489.4)
    instrument = barometer.Barometer(rng())
    altitudes = [instrument.read(500.0).altitude_m for _ in range(COUNT)]
    assert np.mean(altitudes) == pytest.approx(500.0, abs=3.0)
    assert np.std(altitudes) == pytest.approx(0.09, rel=0.1)  # 1 Pa


def test_magnetometer_reads_the_field_turned_into_the_body() -> None:
    compass = magnetometer.Magnetometer(rng())
    mean, std = spread([compass.read(STATE) for _ in range(COUNT)])
    assert std == pytest.approx(magnetometer.NOISE_STD, rel=FIVE_SIGMA)
    north, east, down = rotate(STATE.q_ned_frd, tuple(mean))
    assert (north, east, down) == pytest.approx(magnetometer.FIELD_NED, abs=0.03)


def test_each_sensor_samples_at_its_own_rate() -> None:
    sensors = Sensors([1], altitude_m=489.4)
    readings = [sensors.update(STATE._replace(time_us=4000 * tick)) for tick in range(250)]
    assert len({reading.gps for reading in readings}) == gps.RATE_HZ
    assert len({reading.pressure_hpa for reading in readings}) == barometer.RATE_HZ
    assert len({reading.field_frd for reading in readings}) == magnetometer.RATE_HZ
    assert len({reading.rates_frd for reading in readings}) == 250
    assert all(readings[0].health)


def test_the_seed_decides_everything() -> None:
    first, same, other = (Sensors([seed], altitude_m=0.0).update(STATE) for seed in (1, 1, 2))
    assert first == same
    assert first.rates_frd != other.rates_frd
    assert first.gps != other.gps
