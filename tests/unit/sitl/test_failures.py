"""Failures injected by command: refused unless enabled, and each does what it says."""

import math
from collections.abc import Iterator

import numpy as np
import pytest

from sitl.failures import SUPPORTED, FailureType, FailureUnit
from sitl.modes import Mode
from sitl.simulation import Simulation, SimulationConfig
from sitl.vehicle_records import Command, OffboardSetpoint

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


def test_refused_unless_enabled(vehicle):
    vehicle.parameters.set("SYS_FAILURE_EN", 0)
    assert vehicle.inject(FailureUnit.GPS, FailureType.OFF) == DENIED
    vehicle.run(0.1)
    assert all(vehicle.readings.health)


@pytest.mark.parametrize(
    ("unit", "kind", "instance"),
    [
        *[(5, 1, 0), (99, 1, 0), (4, 8, 0), (4, -1, 0), (NAN, 1, 0), (4, NAN, 0), (4.5, 1, 0)],
        *[
            (101, 3, 0),
            (101, 1, 5),
            (101, 1, -1),
            (100, 2, 0),
            (6, 4, 0),
            (4, 1, 1e30),
            (4, 1, -1e30),
        ],
    ],
)
def test_what_this_vehicle_has_not_is_unsupported(vehicle, unit, kind, instance):
    assert vehicle.inject(unit, kind, instance) == UNSUPPORTED


@pytest.mark.parametrize(
    ("unit", "kind"), [(unit, kind) for unit, kinds in SUPPORTED.items() for kind in sorted(kinds)]
)
def test_everything_supported_is_accepted_and_can_be_mended(vehicle, unit, kind):
    assert vehicle.inject(unit, kind) == ACCEPTED
    vehicle.run(0.1)
    assert vehicle.inject(unit, FailureType.OK, NAN) == ACCEPTED
    vehicle.run(0.02)
    assert all(vehicle.readings.health)
    assert not vehicle.is_silent


def test_without_gps_the_vehicle_lands_after_five_seconds(vehicle):
    vehicle.inject(FailureUnit.GPS, FailureType.OFF)
    vehicle.run(4.98)
    assert vehicle.mode is Mode.HOLD
    vehicle.run(0.2)
    assert vehicle.mode is Mode.LAND
    assert vehicle.readings.gps.fix_type == 0
    vehicle.run(16.0)
    assert not vehicle.autopilot.armed
    assert abs(vehicle.state.position_ned[2]) < 0.1


def test_with_gps_back_the_vehicle_holds_again(vehicle):
    vehicle.inject(FailureUnit.GPS, FailureType.OFF)
    vehicle.run(6.0)
    vehicle.inject(FailureUnit.GPS, FailureType.OK)
    vehicle.run(0.2)
    assert vehicle.mode is Mode.HOLD
    assert math.dist(vehicle.estimate.position_ned, vehicle.state.position_ned) < 1.0


@pytest.mark.parametrize("unit", [FailureUnit.MAGNETOMETER, FailureUnit.BAROMETER])
def test_one_aid_less_is_flown_on_without(vehicle, unit):
    vehicle.inject(unit, FailureType.OFF)
    vehicle.run(10.0)
    assert vehicle.mode is Mode.HOLD
    assert abs(vehicle.state.position_ned[2] + 6.0) < 0.6
    assert not all(vehicle.autopilot.status.armed and vehicle.readings.health)


def test_a_dead_battery_lands_the_vehicle(vehicle):
    vehicle.inject(FailureUnit.BATTERY, FailureType.OFF)
    vehicle.run(5.1)
    assert vehicle.mode is Mode.LAND
    assert vehicle.readings.battery == 0.0


def test_a_dead_motor_brings_the_vehicle_down(vehicle):
    vehicle.inject(FailureUnit.MOTOR, FailureType.OFF, 1)
    vehicle.run(3.0)
    assert vehicle.state.position_ned[2] > -1.0


def test_a_dead_gyro_ends_the_flight(vehicle):
    vehicle.inject(FailureUnit.GYRO, FailureType.OFF)
    vehicle.run(0.02)
    assert vehicle.mode is Mode.TERMINATION


def test_the_signal_comes_and_goes(vehicle):
    vehicle.inject(FailureUnit.MAVLINK_SIGNAL, FailureType.INTERMITTENT)
    vehicle.run(0.5)
    assert vehicle.is_silent
    vehicle.run(1.0)
    assert not vehicle.is_silent
    vehicle.inject(FailureUnit.MAVLINK_SIGNAL, FailureType.OFF)
    vehicle.run(5.0)
    assert vehicle.is_silent


def frames(vehicle: Failing, seconds: float) -> list[np.ndarray]:
    taken = []
    for _ in range(round(seconds * 250)):
        vehicle.step()
        if vehicle.frame_due():
            taken.append(vehicle.render().rgb)
    return taken


@pytest.mark.parametrize(
    ("kind", "count"),
    [(FailureType.OFF, 0), (FailureType.SLOW, 4), (FailureType.INTERMITTENT, 20)],
)
def test_a_camera_that_gives_fewer_images(vehicle, kind, count):
    vehicle.frame_due()
    vehicle.inject(FailureUnit.CAMERA, kind)
    assert len(frames(vehicle, 2.0)) == pytest.approx(count, abs=1)


def test_a_camera_that_gives_other_images(vehicle):
    vehicle.inject(FailureUnit.CAMERA, FailureType.STUCK)
    vehicle.run(0.01)
    stuck = frames(vehicle, 0.5)
    assert all((image == stuck[0]).all() for image in stuck)
    vehicle.inject(FailureUnit.CAMERA, FailureType.GARBAGE)
    vehicle.run(0.01)
    garbage = frames(vehicle, 0.2)
    assert garbage[0].std() > 60.0
    assert (garbage[0] != garbage[1]).any()
