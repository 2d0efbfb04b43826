from collections.abc import Iterator

import pytest

from sitl.hil.connection import Px4Connection
from sitl.hil.controller import ARMED_PATIENT_TICKS, HilController
from sitl.hil.messages import BAROMETER, INERTIAL, MAGNETOMETER
from sitl.records.motion import VehicleState
from sitl.records.sensing import GpsReading, Readings, SensorHealth
from tests.wire.px4_stand_in import ARMED, Px4StandIn

HOME = (47.397742, 8.545594, 489.4)
FIX = GpsReading(4000, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 3, 10)
READINGS = Readings(
    (0.0, 0.0, 0.0),
    (0.0, 0.0, -9.8),
    (0.2, 0.0, 0.4),
    955.0,
    489.0,
    11.0,
    FIX,
    SensorHealth(),
)


ZERO = (0.0, 0.0, 0.0)
STILL = VehicleState(0, ZERO, ZERO, (1.0, 0.0, 0.0, 0.0), ZERO, (0.0, 0.0, -9.8))


class WallClock:
    """Runs by so much each time it is looked at."""

    def __init__(self) -> None:
        self.now_s = 0.0
        self.step_s = 0.0

    def __call__(self) -> float:
        self.now_s += self.step_s
        return self.now_s


class Flight:
    """A controller with a stand-in of PX4, tick by tick."""

    def __init__(self, connection: Px4Connection) -> None:
        self.connection = connection
        self.clock = WallClock()
        self.controller = HilController(
            connection, home=HOME, unix_epoch_us=10**15, clock=self.clock
        )
        self.time_us = 0
        self.px4 = self.connect()

    def connect(self) -> Px4StandIn:
        px4 = Px4StandIn(self.connection.address[1])
        while not self.connection.is_connected:
            self.connection.serve(1.0)
        return px4

    def sense(self, readings: Readings = READINGS) -> None:
        self.time_us += 4000
        state = STILL._replace(time_us=self.time_us)
        self.controller.sense(state, readings)


@pytest.fixture
def flight(connection: Px4Connection) -> Iterator[Flight]:
    flight = Flight(connection)
    yield flight
    flight.px4.socket.close()


def test_motors_are_those_that_answer_the_last_sensors(flight: Flight) -> None:
    for thrust in (0.25, 0.5, 0.75):
        flight.sense()
        sensors = flight.px4.await_sensors()
        assert sensors.time_usec == flight.time_us  # vehicle time is PX4's clock
        flight.px4.answer(sensors.time_usec, thrust, ARMED)
        assert flight.controller.drive() == (thrust,) * 4
        assert flight.controller.armed


def test_an_old_answer_is_not_taken_for_the_new_one(flight: Flight) -> None:
    flight.sense()
    flight.px4.answer(flight.px4.await_sensors().time_usec - 4000, 0.1)
    flight.px4.answer(flight.time_us, 0.5)
    assert flight.controller.drive() == (0.5,) * 4


def test_only_what_is_new_is_said_to_be(flight: Flight) -> None:
    flight.sense()
    flight.sense()
    flight.sense(READINGS._replace(field_frd=(0.3, 0.0, 0.4)))
    flight.sense(READINGS._replace(field_frd=(0.3, 0.0, 0.4), pressure_hpa=954.0))
    fields = [flight.px4.await_sensors().fields_updated for _ in range(4)]
    assert fields == [
        INERTIAL | MAGNETOMETER | BAROMETER,
        INERTIAL,
        INERTIAL | MAGNETOMETER,
        INERTIAL | BAROMETER,
    ]
    assert [m.get_type() for m in flight.px4.others].count("HIL_GPS") == 1
    assert flight.px4.others[0].get_type() == "HIL_STATE_QUATERNION"


def test_where_no_answers_come_time_goes_on_with_the_old_motors(flight: Flight) -> None:
    flight.sense()
    flight.px4.answer(flight.time_us, 0.375)
    assert flight.controller.drive() == (0.375,) * 4
    flight.clock.step_s = 0.06  # so that patience ends
    for _ in range(3):
        flight.sense()
        assert flight.controller.drive() == (0.375,) * 4


def test_a_px4_that_is_armed_is_waited_for_and_it_is_said(
    flight: Flight, caplog: pytest.LogCaptureFixture
) -> None:
    flight.sense()
    flight.px4.answer(flight.time_us, 0.625, ARMED)
    flight.controller.drive()
    flight.clock.step_s = 0.999  # nearly a second of patience, or none is left
    for _ in range(ARMED_PATIENT_TICKS):
        flight.sense()
        before_s = flight.clock.now_s
        flight.controller.drive()
        assert flight.clock.now_s - before_s > 1.0
    assert "waiting for PX4's motor commands: none for 1 s" in caplog.text
    assert "going on without" in caplog.text
    flight.sense()
    flight.px4.answer(flight.time_us, 0.75, ARMED)
    flight.clock.step_s = 0.0
    assert flight.controller.drive() == (0.75,) * 4


def test_motors_stand_when_px4_has_gone_and_another_begins_anew(flight: Flight) -> None:
    flight.sense()
    flight.px4.answer(flight.time_us, 0.625, ARMED)
    assert flight.controller.drive() == (0.625,) * 4
    flight.px4.socket.close()
    flight.sense()
    assert flight.controller.drive() == (0.0,) * 4
    assert not flight.controller.armed
    flight.px4 = flight.connect()
    flight.sense()
    sensors = flight.px4.await_sensors()
    assert sensors.time_usec == flight.time_us  # it only grows
    assert sensors.fields_updated == INERTIAL | MAGNETOMETER | BAROMETER
    assert [m.get_type() for m in flight.px4.others].count("HIL_GPS") == 1  # told once more
