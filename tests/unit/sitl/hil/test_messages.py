import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sitl.hil.environment import px4_environment
from sitl.hil.messages import BAROMETER, INERTIAL, MAGNETOMETER, hil_gps, hil_sensor, read_motors
from sitl.mavlink.wire.dialect import mavlink
from sitl.records.sensing import GpsReading, Readings, SensorHealth
from sitl.world.airframe import load_airframe
from tests.wire.px4_stand_in import RECORDED, recorded

HOME = (47.397742, 8.545594, 489.4)
FIX = GpsReading(4000, (111.19, -10.0, -2.0), (1.0, -2.0, 0.5), 3, 10)
READINGS = Readings(
    (0.1, 0.2, 0.3),
    (0.0, 0.0, -9.80665),
    (0.215, 0.011, 0.433),
    955.5,
    490.0,
    11.8,
    FIX,
    SensorHealth(),
)


def test_sensors_are_sent_in_the_units_and_frames_of_px4() -> None:
    message = hil_sensor(4000, READINGS, INERTIAL | BAROMETER)
    assert (message.time_usec, message.id) == (4000, 0)
    assert (message.xacc, message.yacc, message.zacc) == READINGS.specific_force_frd
    assert (message.xgyro, message.ygyro, message.zgyro) == READINGS.rates_frd
    assert (message.xmag, message.ymag, message.zmag) == READINGS.field_frd
    assert message.abs_pressure == 955.5


def test_the_groups_are_those_of_mavlink() -> None:
    names = {INERTIAL: ("ACC", "GYRO"), MAGNETOMETER: ("MAG",)}
    for group, kinds in names.items():
        bits = [getattr(mavlink, f"HIL_SENSOR_UPDATED_{a}{k}") for k in kinds for a in "XYZ"]
        assert group == sum(bits)
    assert BAROMETER == (
        mavlink.HIL_SENSOR_UPDATED_ABS_PRESSURE
        | mavlink.HIL_SENSOR_UPDATED_PRESSURE_ALT
        | mavlink.HIL_SENSOR_UPDATED_TEMPERATURE
    )


def test_a_fix_is_a_place_on_earth_and_a_velocity_in_cm_s() -> None:
    message = hil_gps(FIX, HOME, unix_us=1_700_000_000_000_000)
    assert message.lat == pytest.approx((HOME[0] + 0.001) * 1e7, abs=2)  # 111.19 m are 0.001 deg
    assert message.lon < HOME[1] * 1e7
    assert message.alt == 491_400
    assert (message.vn, message.ve, message.vd, message.vel) == (100, -200, 50, 224)
    assert message.cog == pytest.approx(29657, abs=1)  # of 36000: to the northwest
    assert (message.eph, message.epv) == (90, 178)  # cm, as PX4 takes them


def test_what_px4_sent_is_read() -> None:
    ground, armed, flying = (read_motors(recorded(index)) for index in (2, 5, 7))
    assert (ground.time_us, ground.armed, ground.thrusts) == (136_000, False, (0.0, 0.0, 0.0, 0.0))
    assert armed.armed
    assert flying.armed
    assert all(0.5 < thrust < 0.65 for thrust in flying.thrusts)
    assert len(RECORDED) == 10


@given(st.lists(st.floats(allow_nan=True), min_size=16, max_size=16))
def test_motors_are_driven_by_shares_whatever_is_sent(controls: list[float]) -> None:
    message = mavlink.MAVLink_hil_actuator_controls_message(4000, controls, 129, 1)
    assert all(0.0 <= thrust <= 1.0 for thrust in read_motors(message).thrusts)


def test_px4_is_told_our_airframe() -> None:
    airframe = load_airframe("x500")
    told = px4_environment(airframe, HOME)
    assert math.isclose(float(told["PX4_PARAM_MPC_THR_HOVER"]), airframe.hover_thrust, rel_tol=1e-3)
    for rotor, place in enumerate(airframe.rotors.positions_frd_m):
        named = [float(told[f"PX4_PARAM_CA_ROTOR{rotor}_P{axis}"]) for axis in "XY"]
        assert tuple(named) == place
    assert float(told["PX4_HOME_LAT"]) == HOME[0]
