"""Whole flights, against what a real PX4 was seen doing."""

import math
from collections.abc import Callable
from typing import Any

import pytest

from sitl.frames import yaw_of
from sitl.records.modes import Mode
from sitl.records.vehicle import VehicleStatus
from tests.unit.sitl.autopilot.conftest import Flight

NAN = math.nan
ARM, TAKEOFF, LAND, RTL, REPOSITION = 400, 22, 21, 20, 192
NORTH_DEG, LONGITUDE_DEG = 47.397742 + 15.0 / 111_195.0, 8.545594  # 15 m north of home
ON_GROUND, IN_AIR, TAKING_OFF, LANDING = 1, 2, 3, 4
ZERO = (0.0, 0.0, 0.0)


def test_take_off_holds_at_its_altitude(flight: Flight) -> None:
    flight.run(1.5)
    flight.command(ARM, 1.0)
    assert flight.command(TAKEOFF) == 0

    def status() -> VehicleStatus:
        return flight.autopilot.status

    lifted_s = flight.run_until(lambda: status().landed_state == TAKING_OFF, timeout_s=3.0)
    hovering_s = flight.run_until(lambda: status().landed_state == IN_AIR, timeout_s=10.0)
    assert lifted_s == pytest.approx(1.8, abs=0.4)  # PX4: 1.8 s after arming
    assert lifted_s + hovering_s == pytest.approx(6.3, abs=0.7)  # PX4: 6.3 s
    assert status().mode is Mode.HOLD
    assert 2.1 <= flight.height_m <= 2.9  # PX4's band
    highest = 0.0
    for _ in range(20):
        flight.run(0.2)
        highest = max(highest, flight.height_m)
    assert highest < 2.55 + 0.05  # 2.5 m above where it stood, hardly any overshoot
    assert flight.height_m == pytest.approx(2.55, abs=0.02)
    assert math.hypot(*flight.estimate.velocity_ned) < 0.02


def test_take_off_says_what_px4_says(flight: Flight) -> None:
    flight.take_off()
    assert flight.said == [
        "6:Ready for takeoff!",
        "6:Armed by external command",
        "6:Using default takeoff altitude: 2.5 m",
        "6:Takeoff detected",
    ]


def test_take_off_altitude_is_above_mean_sea_level(flight: Flight) -> None:
    flight.take_off(altitude_m=6.0)
    assert flight.height_m == pytest.approx(6.0, abs=0.05)


def test_landing_touches_down_disarms_and_falls_back_to_hold(flight: Flight) -> None:
    flight.take_off()
    flight.texts.clear()
    assert flight.command(LAND) == 0
    flight.run(0.1)
    assert flight.autopilot.status.landed_state == LANDING
    assert flight.autopilot.status.custom_mode == 0x06040000
    landed_s = flight.run_until(
        lambda: flight.autopilot.status.landed_state == ON_GROUND, timeout_s=12.0
    )
    assert 5.0 < landed_s < 10.2  # PX4: 9.3..10.2 s, from 3 m and over a noisy estimate
    disarmed_s = flight.run_until(lambda: not flight.autopilot.status.armed, timeout_s=4.0)
    assert 2.0 <= disarmed_s <= 3.0
    status = flight.autopilot.status
    assert (status.mode, status.system_status, status.base_mode) == (Mode.HOLD, 3, 29)
    assert flight.said == [
        "6:Landing at current position",
        "6:Landing detected",
        "6:Disarmed by landing",
    ]


def test_touch_down_is_gentle(flight: Flight) -> None:
    flight.take_off()
    flight.command(LAND)
    fastest = 0.0
    while flight.autopilot.status.armed:
        flight.step()
        fastest = max(fastest, flight.estimate.velocity_ned[2])
    assert fastest < 0.8  # MPC_LAND_SPEED 0.7


@pytest.mark.parametrize("speed", [1.0, 5.0])
def test_hold_stops_without_bouncing_back(flight: Flight, speed: float) -> None:
    flight.place((0.0, 0.0, -10.0))
    flight.send(velocity_ned=(0.0, speed, 0.0), yaw_rate_rad_s=0.0)
    flight.run(4.0)
    assert flight.autopilot.set_mode(4, 3).result == 0
    backwards = 0.0
    for _ in range(2000):
        flight.step()
        backwards = min(backwards, flight.estimate.velocity_ned[1])
    assert backwards > -0.1
    assert math.hypot(*flight.estimate.velocity_ned) < 0.05
    assert flight.height_m == pytest.approx(10.0, abs=0.2)


def test_hold_resists_wind(flight: Flight) -> None:
    flight.place((0.0, 0.0, -10.0))
    flight.autopilot.set_mode(4, 3)
    flight.run(3.0)
    flight.body.wind_ned = (4.0, -3.0, 0.0)
    flight.run(15.0)
    x, y, z = flight.estimate.position_ned
    assert math.hypot(x, y) < 0.3
    assert z == pytest.approx(-10.0, abs=0.1)


def test_reposition_flies_to_a_place_and_stays(flight: Flight) -> None:
    flight.take_off()
    latitude, longitude = 47.397742 + math.degrees(20.0 / 6371000.0), 8.545594
    assert (
        flight.command(REPOSITION, -1.0, 1.0, 0.0, NAN, latitude, longitude, 489.4 + 8.0, frame=5)
        == 0
    )
    flight.run(15.0)
    x, y, z = flight.estimate.position_ned
    assert (x, y, z) == pytest.approx((20.0, 0.0, -8.0), abs=0.1)
    assert flight.command(REPOSITION, -1.0, 0.0) == 3


def test_return_climbs_flies_home_lands_and_disarms(flight: Flight) -> None:
    flight.parameters.set("RTL_RETURN_ALT", 12.0)
    flight.place((15.0, -5.0, -6.0))
    assert flight.command(RTL) == 0
    flight.run(0.1)
    assert flight.autopilot.status.custom_mode == 0x05040000
    assert "6:RTL: start return at 501 m (12 m above destination)" in flight.said
    highest = 0.0
    while flight.autopilot.status.armed and flight.time_us < 90e6:
        flight.step()
        highest = max(highest, flight.height_m)
    assert highest == pytest.approx(12.0, abs=0.3)
    x, y, _ = flight.estimate.position_ned
    assert math.hypot(x, y) < 0.2
    assert not flight.autopilot.status.armed


def test_return_from_above_home_lands_without_climbing(flight: Flight) -> None:
    flight.take_off()
    flight.command(RTL)
    highest = 0.0
    for _ in range(2500):
        flight.step()
        highest = max(highest, flight.height_m)
    assert highest < 2.7


def test_return_near_home_turns_before_it_descends(flight: Flight) -> None:
    """PX4 lands in the heading in which it stood at home."""
    flight.take_off(6.0)
    flight.command(REPOSITION, -1.0, 1.0, NAN, -math.pi / 2, NAN, NAN, NAN)
    flight.run(8.0)
    assert yaw(flight) == pytest.approx(-math.pi / 2, abs=0.1)
    flight.command(RTL)
    flight.run_until(lambda: abs(yaw(flight)) < math.radians(13.0), timeout_s=8.0)
    assert flight.height_m == pytest.approx(6.0, abs=0.3)
    flight.run_until(lambda: flight.height_m < 3.0, timeout_s=10.0)
    assert yaw(flight) == pytest.approx(0.0, abs=0.05)


def test_return_with_a_heading_timeout_descends_while_it_turns(flight: Flight) -> None:
    """PX4: with MIS_YAW_TMT, only forced headings are waited for, and a return forces none."""
    flight.parameters.set("MIS_YAW_TMT", 5.0)
    flight.take_off(6.0)
    flight.command(REPOSITION, -1.0, 1.0, NAN, -math.pi / 2, NAN, NAN, NAN)
    flight.run(8.0)
    flight.command(RTL)
    flight.run_until(lambda: flight.height_m < 5.5, timeout_s=3.0)
    assert yaw(flight) < math.radians(-20.0)
    flight.run_until(lambda: flight.height_m < 2.0, timeout_s=10.0)
    assert yaw(flight) == pytest.approx(0.0, abs=0.05)


def test_return_from_afar_turns_while_it_descends(flight: Flight) -> None:
    flight.take_off(6.0)
    flight.command(REPOSITION, -1.0, 1.0, NAN, math.pi / 2, NORTH_DEG, LONGITUDE_DEG, 495.4)
    flight.run_until(lambda: flight.estimate.position_ned[0] > 14.0, timeout_s=15.0)
    flight.command(RTL)
    flight.run_until(lambda: abs(flight.estimate.position_ned[0]) < 2.0, timeout_s=60.0)
    assert abs(yaw(flight)) == pytest.approx(math.pi, abs=0.1)  # the way home
    flight.run_until(lambda: flight.height_m < 10.0, timeout_s=30.0)
    assert yaw(flight) == pytest.approx(0.0, abs=0.1)


def yaw(flight: Flight) -> float:
    return yaw_of(flight.estimate.q_ned_frd)


def test_offboard_take_off_and_landing_by_velocity(flight: Flight) -> None:
    flight.run(1.1)
    flight.send(velocity_ned=ZERO, yaw_rate_rad_s=0.0)
    flight.autopilot.set_mode(6, 0)
    flight.run(1.0)
    assert flight.command(ARM, 1.0) == 0
    flight.send(velocity_ned=(0.0, 0.0, -1.0), yaw_rate_rad_s=0.0)

    def status() -> VehicleStatus:
        return flight.autopilot.status

    lifted_s = flight.run_until(lambda: status().landed_state == IN_AIR, timeout_s=4.0)
    assert 1.0 < lifted_s < 2.0  # PX4: 2 s after arming, read from a stream of 5 Hz
    climbed_s = flight.run_until(lambda: flight.height_m > 5.0, timeout_s=10.0)
    assert lifted_s + climbed_s == pytest.approx(8.3, abs=1.2)
    flight.send(velocity_ned=(0.0, 0.0, 0.7), yaw_rate_rad_s=0.0)
    flight.run_until(lambda: status().landed_state == ON_GROUND, timeout_s=15.0)
    disarmed_s = flight.run_until(lambda: not status().armed, timeout_s=4.0)
    assert disarmed_s == pytest.approx(2.4, abs=0.6)
    assert status().mode is Mode.OFFBOARD


def test_idle_in_offboard_stays_on_the_ground_and_disarms(flight: Flight) -> None:
    flight.run(1.1)
    flight.send(velocity_ned=ZERO, yaw_rate_rad_s=0.0)
    flight.autopilot.set_mode(6, 0)
    flight.run(1.0)
    flight.command(ARM, 1.0)
    disarmed_s = flight.run_until(lambda: not flight.autopilot.status.armed, timeout_s=12.0)
    assert disarmed_s == pytest.approx(10.0, abs=0.1)
    assert flight.height_m < 0.06
    assert flight.said[-1] == "6:Disarmed by auto preflight disarming"
    assert flight.autopilot.status.mode is Mode.OFFBOARD


def test_offboard_position_setpoint_is_reached(flight: Flight) -> None:
    flight.place((0.0, 0.0, -5.0))
    flight.send(position_ned=(5.0, 0.0, -8.0), yaw_rad=0.0)
    reached_s = flight.run_until(
        lambda: math.dist(flight.estimate.position_ned, (5.0, 0.0, -8.0)) < 0.3, timeout_s=8.0
    )
    assert 2.0 < reached_s < 5.3  # PX4: 2.8..4.6 s
    flight.run(4.0)
    assert math.dist(flight.estimate.position_ned, (5.0, 0.0, -8.0)) < 0.17  # PX4: 0.17..0.48


def test_neither_yaw_nor_yaw_rate_holds_the_heading(flight: Flight) -> None:
    flight.place((0.0, 0.0, -5.0), yaw_rad=1.0)
    flight.send(velocity_ned=(2.0, 0.0, 0.0))
    flight.run(4.0)
    assert flight.autopilot.yaw_rad == pytest.approx(1.0, abs=0.02)
    assert flight.autopilot.setpoint_echo.yaw_rad == pytest.approx(1.0, abs=0.001)


def test_yaw_setpoint_is_reached_without_drifting_off(flight: Flight) -> None:
    flight.place((0.0, 0.0, -5.0))
    flight.send(velocity_ned=ZERO, yaw_rad=math.radians(50.0))
    furthest = 0.0
    for _ in range(1500):
        flight.step()
        furthest = max(furthest, flight.autopilot.yaw_rad)
    assert flight.autopilot.yaw_rad == pytest.approx(math.radians(50.0), abs=0.02)
    assert furthest < math.radians(53.0)  # as PX4 was seen to
    assert math.hypot(*flight.estimate.position_ned[:2]) < 0.6


def test_same_inputs_give_the_same_flight_to_the_last_bit(make_flight: Callable[..., Any]) -> None:
    paths = []
    for _ in range(2):
        flight, path = make_flight(), []
        flight.take_off()
        flight.send(velocity_ned=(1.0, 0.5, -0.2), yaw_rate_rad_s=0.3)
        flight.run(1.0)
        flight.autopilot.set_mode(6, 0)
        for _ in range(500):
            flight.step()
            path.append(flight.estimate)
        paths.append(path)
    assert paths[0] == paths[1]


def test_a_change_of_parameters_acts_in_flight(flight: Flight) -> None:
    flight.place((0.0, 0.0, -5.0))
    flight.send(velocity_ned=(0.0, 0.0, -3.0), yaw_rate_rad_s=0.0)
    flight.run(2.0)
    flight.parameters.set("MPC_Z_VEL_MAX_UP", 1.0)
    flight.run(2.0)
    assert flight.estimate.velocity_ned[2] == pytest.approx(-1.0, abs=0.1)
