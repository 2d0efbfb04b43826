"""Failures injected by command: refused unless enabled, and each does what it says."""

import math
from collections.abc import Iterator

import numpy as np
import pytest

from sitl.flown_vehicle import SimulationConfig
from sitl.records.failures import SUPPORTED, Failure, FailureType, FailureUnit
from sitl.records.modes import Mode
from sitl.records.vehicle import Command, OffboardSetpoint
from sitl.sensors.breakage import Breakage
from sitl.simulation import Simulation

NAN = math.nan
ACCEPTED, DENIED, UNSUPPORTED = 0, 2, 3


class Failing(Simulation):
    """A vehicle that hovers by itself, and takes failures."""

    def __init__(self) -> None:
        super().__init__(SimulationConfig(seed=4))
        self.parameters.set("SYS_FAILURE_EN", 1)
        self.start_airborne((0.0, 0.0, -6.0), 0.0)
        self.autopilot.offboard_setpoint(
            OffboardSetpoint(time_us=0, velocity_ned=(0.0, 0.0, 0.0), yaw_rate_rad_s=0.0)
        )
        self.step()
        self.autopilot.set_mode(4, 3)
        self.run(0.5)

    def run(self, seconds: float) -> None:
        for _ in range(round(seconds * 250)):
            self.step()

    def inject(self, unit: float, kind: float, instance: float = 0.0) -> int:
        answer = self.autopilot.command(
            Command(command=420, params=(unit, kind, instance, NAN, NAN, NAN, NAN))
        )
        assert answer is not None
        return answer.result

    @property
    def mode(self) -> Mode:
        return self.autopilot.status.mode


@pytest.fixture
def vehicle() -> Iterator[Failing]:
    vehicle = Failing()
    yield vehicle
    vehicle.close()


def test_refused_unless_enabled(vehicle: Failing) -> None:
    vehicle.parameters.set("SYS_FAILURE_EN", 0)
    assert vehicle.inject(FailureUnit.GPS, FailureType.OFF) == DENIED
    vehicle.run(0.1)
    assert all(vehicle.readings.health)


@pytest.mark.parametrize(
    ("unit", "kind", "instance"),
    [
        *[(5, 1, 0), (99, 1, 0), (4, 8, 0), (4, -1, 0), (NAN, 1, 0), (4, NAN, 0), (4.5, 1, 0)],
        *[
            (105, 2, 0),
            (105, 4, 0),
            (101, 1, 5),
            (101, 1, -1),
            (6, 4, 0),
            (4, 1, 1e30),
            (4, 1, -1e30),
        ],
    ],
)
def test_what_this_vehicle_has_not_is_unsupported(
    vehicle: Failing, unit: float, kind: float, instance: float
) -> None:
    assert vehicle.inject(unit, kind, instance) == UNSUPPORTED


@pytest.mark.parametrize(
    ("unit", "kind"), [(unit, kind) for unit, kinds in SUPPORTED.items() for kind in sorted(kinds)]
)
def test_everything_supported_is_accepted_and_can_be_mended(
    vehicle: Failing, unit: FailureUnit, kind: FailureType
) -> None:
    assert vehicle.inject(unit, kind) == ACCEPTED
    vehicle.run(0.1)
    assert vehicle.inject(unit, FailureType.OK, NAN) == ACCEPTED
    vehicle.run(0.02)
    assert all(vehicle.readings.health)
    assert not vehicle.is_silent


def test_without_gps_the_vehicle_lands_after_five_seconds(vehicle: Failing) -> None:
    vehicle.inject(FailureUnit.GPS, FailureType.OFF)
    vehicle.run(4.98)
    assert vehicle.mode is Mode.HOLD
    vehicle.run(0.2)
    assert vehicle.mode is Mode.LAND
    assert vehicle.readings.gps.fix_type == 0
    vehicle.run(16.0)
    assert not vehicle.autopilot.armed
    assert abs(vehicle.state.position_ned[2]) < 0.1


def test_with_gps_back_the_vehicle_holds_again(vehicle: Failing) -> None:
    vehicle.inject(FailureUnit.GPS, FailureType.OFF)
    vehicle.run(6.0)
    vehicle.inject(FailureUnit.GPS, FailureType.OK)
    vehicle.run(0.2)
    assert vehicle.mode is Mode.HOLD
    assert math.dist(vehicle.estimate.position_ned, vehicle.state.position_ned) < 1.0


@pytest.mark.parametrize("unit", [FailureUnit.MAGNETOMETER, FailureUnit.BAROMETER])
def test_one_aid_less_is_flown_on_without(vehicle: Failing, unit: FailureUnit) -> None:
    vehicle.inject(unit, FailureType.OFF)
    vehicle.run(10.0)
    assert vehicle.mode is Mode.HOLD
    assert abs(vehicle.state.position_ned[2] + 6.0) < 0.6
    assert vehicle.autopilot.status.armed
    assert not all(vehicle.readings.health)


def test_a_dead_battery_lands_the_vehicle(vehicle: Failing) -> None:
    vehicle.inject(FailureUnit.BATTERY, FailureType.OFF)
    vehicle.run(5.1)
    assert vehicle.mode is Mode.LAND
    assert vehicle.readings.battery == 0.0


def test_a_dead_motor_brings_the_vehicle_down(vehicle: Failing) -> None:
    vehicle.inject(FailureUnit.MOTOR, FailureType.OFF, 1)
    vehicle.run(3.0)
    assert vehicle.state.position_ned[2] > -1.0


@pytest.mark.parametrize(
    ("kind", "after_s", "least", "most"),
    [
        (FailureType.OFF, 0.1, 0.0, 0.0),
        (FailureType.STUCK, 3.0, 0.8, 0.8),
        (FailureType.WRONG, 0.1, 1.0, 1.0),  # 0.3 more than there is
        (FailureType.SLOW, 0.1, 0.7, 0.8),
        (FailureType.DELAYED, 0.1, 0.8, 0.8),
        (FailureType.INTERMITTENT, 0.5, 0.0, 0.0),
        (FailureType.INTERMITTENT, 1.5, 0.7, 0.8),
    ],
)
def test_a_battery_that_is_not_read_well(
    vehicle: Failing, kind: FailureType, after_s: float, least: float, most: float
) -> None:
    vehicle.parameters.set("SIM_BAT_MIN_PCT", 0.0)
    vehicle.parameters.set("SIM_BAT_DRAIN", 20.0)
    while vehicle.readings.battery > 0.8:
        vehicle.step()
    vehicle.inject(FailureUnit.BATTERY, kind)
    vehicle.run(after_s)
    slack = 0.001
    assert least - slack <= vehicle.readings.battery <= most + slack
    vehicle.inject(FailureUnit.BATTERY, FailureType.OK)
    vehicle.run(0.02)
    assert 0.5 < vehicle.readings.battery < 0.8


def test_a_battery_that_reads_chance(vehicle: Failing) -> None:
    vehicle.inject(FailureUnit.BATTERY, FailureType.GARBAGE)
    charges = []
    for _ in range(100):
        vehicle.step()
        charges.append(vehicle.readings.battery)
    assert len(set(charges[1:])) > 50
    assert all(0.0 <= charge <= 1.0 for charge in charges)


def driven(kind: FailureType, thrusts: list[float]) -> list[float]:
    """What a failing second motor does, a command a tick."""
    broken = Breakage(np.random.default_rng(1))
    broken.drive((0.6,) * 4, 0)
    broken.fail(Failure(FailureUnit.MOTOR, kind, 2), 0)
    given = [broken.drive((thrust,) * 4, 4000 * n) for n, thrust in enumerate(thrusts)]
    assert [(a, c, d) for a, _, c, d in given] == [(thrust,) * 3 for thrust in thrusts]
    return [b for _, b, _, _ in given]


def test_motors_fail_in_every_way() -> None:
    rising = [0.2 + 0.001 * n for n in range(500)]  # two seconds
    assert driven(FailureType.OFF, rising) == [0.0] * 500
    assert driven(FailureType.STUCK, rising) == [0.6] * 500
    assert driven(FailureType.DELAYED, rising) == [0.6] * 125 + rising[:375]
    assert driven(FailureType.INTERMITTENT, rising) == [0.0] * 250 + rising[250:]
    slow = driven(FailureType.SLOW, rising)
    assert len(set(slow)) == 51
    assert slow[9::10] == rising[9::10]
    wrong = driven(FailureType.WRONG, rising)
    assert wrong == [min(thrust + 0.5, 1.0) for thrust in rising]
    garbage = driven(FailureType.GARBAGE, rising)
    assert len(set(garbage)) > 400
    assert all(0.0 <= thrust <= 1.0 for thrust in garbage)


def test_a_dead_gyro_ends_the_flight(vehicle: Failing) -> None:
    vehicle.inject(FailureUnit.GYRO, FailureType.OFF)
    vehicle.run(0.02)
    assert vehicle.mode is Mode.TERMINATION


def test_the_signal_comes_and_goes(vehicle: Failing) -> None:
    vehicle.inject(FailureUnit.MAVLINK_SIGNAL, FailureType.INTERMITTENT)
    vehicle.run(0.5)
    assert vehicle.is_silent
    vehicle.run(1.0)
    assert not vehicle.is_silent
    vehicle.inject(FailureUnit.MAVLINK_SIGNAL, FailureType.OFF)
    vehicle.run(5.0)
    assert vehicle.is_silent


def images(vehicle: Failing, seconds: float) -> list[np.ndarray]:
    taken = []
    for _ in range(round(seconds * 250)):
        vehicle.step()
        if vehicle.image_due():
            taken.append(vehicle.render().rgb)
    return taken


@pytest.mark.parametrize(
    ("kind", "count"),
    [
        (FailureType.OFF, 0),
        (FailureType.SLOW, 4),
        (FailureType.INTERMITTENT, 20),
        (FailureType.DELAYED, 31),  # the first at once, then those of 1.5 s
    ],
)
def test_a_camera_that_gives_fewer_images(vehicle: Failing, kind: FailureType, count: int) -> None:
    vehicle.image_due()
    vehicle.inject(FailureUnit.CAMERA, kind)
    assert len(images(vehicle, 2.0)) == pytest.approx(count, abs=1)


def test_a_camera_that_gives_other_images(vehicle: Failing) -> None:
    vehicle.inject(FailureUnit.CAMERA, FailureType.STUCK)
    vehicle.run(0.01)
    stuck = images(vehicle, 0.5)
    assert all((image == stuck[0]).all() for image in stuck)
    vehicle.inject(FailureUnit.CAMERA, FailureType.GARBAGE)
    vehicle.run(0.01)
    garbage = images(vehicle, 0.2)
    assert garbage[0].std() > 60.0
    assert (garbage[0] != garbage[1]).any()


def test_a_camera_that_is_late_keeps_its_stamps(vehicle: Failing) -> None:
    vehicle.inject(FailureUnit.CAMERA, FailureType.DELAYED)
    late_us = []
    for _ in range(500):
        vehicle.step()
        if vehicle.image_due():
            stamp, image = vehicle.image_stamp, vehicle.render()
            assert stamp == (image.time_us, image.sequence)
            late_us.append(vehicle.time_us - image.time_us)
    assert late_us[0] == 0
    assert all(500_000 <= late <= 504_000 for late in late_us[1:])
    vehicle.inject(FailureUnit.CAMERA, FailureType.OK)
    vehicle.run(0.01)
    while not vehicle.image_due():
        vehicle.step()
    assert vehicle.render().time_us == vehicle.time_us
