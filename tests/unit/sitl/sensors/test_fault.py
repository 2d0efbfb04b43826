"""A failed sensor gives what its failure says, and the estimate does without it in time."""

import pytest

from sitl.records.failures import FailureType, FailureUnit
from sitl.records.motion import VehicleState
from sitl.records.sensing import Readings
from sitl.sensors.suite import UNITS, Sensors

STATE = VehicleState(
    0, (1.0, 2.0, -3.0), (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, -9.8)
)
FIELDS = ("rates_frd", "specific_force_frd", "field_frd", "pressure_hpa", "gps")
TICK_US = 4000


class Bench:
    """Sensors of a vehicle that stands still, read tick by tick."""

    def __init__(self) -> None:
        self.sensors = Sensors([0], altitude_m=489.4)
        self.time_us = 0
        self.run(1.0)

    def run(self, seconds: float) -> list[Readings]:
        readings = []
        for _ in range(round(seconds * 250)):
            readings.append(self.sensors.update(STATE._replace(time_us=self.time_us)))
            self.time_us += TICK_US
        return readings


@pytest.fixture
def bench() -> Bench:
    return Bench()


def distinct(readings: list[Readings], unit: FailureUnit) -> int:
    field = FIELDS[UNITS.index(unit)]
    return len({getattr(reading, field) for reading in readings})


def well(reading: Readings, unit: FailureUnit) -> bool:
    return reading.health[UNITS.index(unit)]


@pytest.mark.parametrize("unit", UNITS)
def test_off_gives_nothing_and_is_seen_at_once(bench: Bench, unit: FailureUnit) -> None:
    bench.sensors.fail(unit, FailureType.OFF, bench.time_us)
    readings = bench.run(2.0)
    assert distinct(readings, unit) <= 2
    assert not well(readings[0], unit)
    assert sum(readings[0].health) == 4
    if unit is FailureUnit.GPS:
        assert (readings[-1].gps.fix_type, readings[-1].gps.satellites) == (0, 0)
    bench.sensors.fail(unit, FailureType.OK, bench.time_us)
    assert all(bench.run(0.2)[-1].health)


@pytest.mark.parametrize("unit", UNITS)
@pytest.mark.parametrize(
    "kind", [FailureType.STUCK, FailureType.GARBAGE, FailureType.WRONG], ids=lambda kind: kind.name
)
def test_senseless_readings_are_seen_after_a_second(
    bench: Bench, unit: FailureUnit, kind: FailureType
) -> None:
    before = bench.run(0.2)[-1]
    bench.sensors.fail(unit, kind, bench.time_us)
    readings = bench.run(1.5)
    assert well(readings[249], unit)
    assert not well(readings[251], unit)
    field = FIELDS[UNITS.index(unit)]
    if kind is FailureType.STUCK:
        assert getattr(readings[200], field) == getattr(before, field)
    else:
        assert distinct(readings[150:], unit) > 2


@pytest.mark.parametrize("unit", UNITS)
def test_slow_gives_a_tenth(bench: Bench, unit: FailureUnit) -> None:
    usual = distinct(bench.run(20.0), unit)
    bench.sensors.fail(unit, FailureType.SLOW, bench.time_us)
    readings = bench.run(20.0)
    assert distinct(readings, unit) == pytest.approx(usual / 10, abs=2)
    assert all(readings[-1].health)


def test_delayed_gives_what_was_half_a_second_ago(bench: Bench) -> None:
    bench.sensors.fail(FailureUnit.GYRO, FailureType.DELAYED, bench.time_us)
    first = bench.run(0.5)
    assert distinct(first, FailureUnit.GYRO) == 1
    assert distinct(bench.run(0.5), FailureUnit.GYRO) == 125


def test_intermittent_comes_and_goes_each_second(bench: Bench) -> None:
    bench.sensors.fail(FailureUnit.BAROMETER, FailureType.INTERMITTENT, bench.time_us)
    readings = bench.run(4.0)
    health = [well(reading, FailureUnit.BAROMETER) for reading in readings]
    assert health == [False] * 250 + [True] * 250 + [False] * 250 + [True] * 250
    assert distinct(readings[1:250], FailureUnit.BAROMETER) == 1
    assert distinct(readings[250:500], FailureUnit.BAROMETER) == 25
