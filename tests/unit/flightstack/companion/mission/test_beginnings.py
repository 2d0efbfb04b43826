"""From waiting to flying: each transition of the mission, without socket, thread or clock."""

from dataclasses import replace

import pytest

from flightstack.companion.mission.machine import RETRY_US
from flightstack.companion.mission.records import MissionPhase, MissionRequest, Outcome
from flightstack.mavlink.telemetry import Course
from flightstack.px4_modes import Px4Mode
from tests.unit.flightstack.companion.mission.made_mission import (
    AIRBORNE,
    IN_FLIGHT,
    NOW,
    OFFBOARD,
    READY,
    Mission,
    S,
)


def test_streams_for_a_second_before_arming() -> None:
    mission = Mission()
    assert mission.see(READY, 0.95) is MissionPhase.WAITING
    assert mission.see(READY, 1.0) is MissionPhase.ARMING
    assert mission.requests == [MissionRequest.ARM]


def test_waits_until_the_vehicle_can_be_armed() -> None:
    mission = Mission()
    for second in range(1, 20):
        assert mission.see(replace(READY, armable=False), second) is MissionPhase.WAITING
    assert mission.requests == []
    assert mission.see(READY, 20) is MissionPhase.ARMING


def test_asks_for_a_home_that_is_not_told() -> None:
    mission = Mission()
    homeless = replace(READY, home_altitude_amsl_m=None)
    assert mission.see(homeless, 2) is MissionPhase.WAITING
    assert mission.requests == []
    mission.see(homeless, 3)
    assert mission.requests == [MissionRequest.HOME_POSITION]
    assert mission.see(READY, 4) is MissionPhase.ARMING


def test_leaves_a_mode_that_cannot_be_armed() -> None:
    mission = Mission()
    mission.see(replace(READY, armable=False, custom_mode=Px4Mode.POSITION), 2)
    assert mission.requests == [MissionRequest.HOLD_MODE]


def test_goes_on_from_a_vehicle_that_is_armed_already_where_told_to() -> None:
    mission = Mission(takes_over=True)
    assert mission.see(replace(READY, armed=True), 1) is MissionPhase.TAKING_OFF
    assert mission.requests == [MissionRequest.TAKE_OFF]


@pytest.mark.parametrize("mode", [Px4Mode.LOITER, Px4Mode.OFFBOARD, Px4Mode.TAKEOFF, Px4Mode.LAND])
def test_lands_what_a_flight_before_has_left_in_the_air(mode: Px4Mode) -> None:
    mission = Mission()
    left = replace(AIRBORNE, custom_mode=mode)
    assert mission.see(left, 2.9) is MissionPhase.WAITING
    assert mission.see(left, 3.0) is MissionPhase.LANDING
    assert mission.requests == [MissionRequest.LAND]
    assert mission.status.outcome is Outcome.FOUND_ARMED


@pytest.mark.parametrize("mode", list(Px4Mode))
def test_disarms_what_it_finds_armed_on_the_ground(mode: Px4Mode) -> None:
    mission = Mission()
    assert mission.see(replace(READY, armed=True, custom_mode=mode), 3) is MissionPhase.LANDING
    assert mission.requests == [MissionRequest.DISARM]
    assert mission.see(READY, 4) is MissionPhase.DONE
    assert mission.status.outcome is Outcome.FOUND_ARMED


@pytest.mark.parametrize("takes_over", [False, True])
def test_somebody_elses_vehicle_is_not_armed(takes_over: bool) -> None:  # noqa: FBT001
    mission = Mission(takes_over=takes_over)
    phase = mission.see(READY, 1, other=True)
    assert phase is (MissionPhase.ARMING if takes_over else MissionPhase.DONE)
    if not takes_over:
        assert (mission.requests, mission.status.outcome) == ([], Outcome.OTHER_PILOT)


def test_goes_on_from_a_vehicle_that_holds_in_the_air_where_told_to() -> None:
    mission = Mission(takes_over=True)
    assert mission.see(AIRBORNE, 1) is MissionPhase.ENTERING_OFFBOARD
    assert mission.requests == [MissionRequest.OFFBOARD_MODE]


def test_does_not_take_a_vehicle_from_its_pilot() -> None:
    mission = Mission()
    assert mission.see(replace(AIRBORNE, custom_mode=Px4Mode.POSITION), 5) is MissionPhase.WAITING
    assert mission.requests == []


def test_a_course_that_is_over_is_not_flown() -> None:
    mission = Mission()
    over = Course(gates_passed=8, gates_total=8, finished=True)
    assert mission.see(replace(READY, course=over), 2) is MissionPhase.DONE
    assert mission.status.outcome is Outcome.COURSE_OVER


def test_arms_again_until_armed() -> None:
    mission = Mission(MissionPhase.ARMING, requested_us=NOW)
    mission.see(READY, RETRY_US / S - 0.1)
    assert mission.requests == []
    mission.see(READY, RETRY_US / S)
    assert mission.requests == [MissionRequest.ARM]
    assert mission.see(replace(READY, armed=True), 4) is MissionPhase.TAKING_OFF


def test_gives_up_a_vehicle_that_will_not_arm() -> None:
    mission = Mission(MissionPhase.ARMING)
    assert mission.see(READY, 21) is MissionPhase.LANDING
    assert mission.requests == [MissionRequest.DISARM]
    assert mission.see(READY, 22) is MissionPhase.DONE
    assert mission.status.outcome is Outcome.REFUSED


def test_enters_offboard_once_it_hovers() -> None:
    mission = Mission(MissionPhase.TAKING_OFF, requested_us=NOW)
    climbing = replace(AIRBORNE, custom_mode=Px4Mode.TAKEOFF, velocity_ned=(0.0, 0.0, -1.5))
    assert mission.see(climbing, 2) is MissionPhase.TAKING_OFF
    overshooting = replace(AIRBORNE, velocity_ned=(0.0, 0.0, -0.5))
    assert mission.see(overshooting, 6) is MissionPhase.TAKING_OFF
    assert mission.see(AIRBORNE, 7) is MissionPhase.TAKING_OFF
    assert mission.see(AIRBORNE, 7.5) is MissionPhase.TAKING_OFF
    assert mission.see(AIRBORNE, 8) is MissionPhase.ENTERING_OFFBOARD
    assert mission.requests == [MissionRequest.OFFBOARD_MODE]


def test_an_estimate_that_never_rests_does_not_hold_it_up() -> None:
    mission = Mission(MissionPhase.TAKING_OFF, confirmed=True)
    restless = replace(AIRBORNE, velocity_ned=(0.4, 0.0, 0.0))
    assert mission.see(restless, 20) is MissionPhase.TAKING_OFF
    assert mission.see(restless, 20.1) is MissionPhase.ENTERING_OFFBOARD


def test_takes_off_again_until_the_mode_shows() -> None:
    mission = Mission(MissionPhase.TAKING_OFF, requested_us=NOW)
    armed = replace(READY, armed=True)
    mission.see(armed, 2.9)
    mission.see(armed, 3.0)
    assert mission.requests == [MissionRequest.TAKE_OFF]


def test_a_vehicle_that_disarms_before_it_lifts_off_has_refused() -> None:
    mission = Mission(MissionPhase.TAKING_OFF)
    mission.see(READY, 11)
    assert mission.status.outcome is Outcome.REFUSED


@pytest.mark.parametrize("phase", IN_FLIGHT)
def test_hands_off_when_somebody_changes_the_mode(phase: MissionPhase) -> None:
    mission = Mission(phase, confirmed=True)
    assert (
        mission.see(replace(AIRBORNE, custom_mode=Px4Mode.POSITION), 1) is MissionPhase.TAKEN_OVER
    )
    assert (mission.requests, mission.status.outcome) == ([], Outcome.TAKEN_OVER)


def test_offboard_is_believed_from_the_heartbeat_alone() -> None:
    mission = Mission(MissionPhase.ENTERING_OFFBOARD, requested_us=NOW)
    assert mission.see(AIRBORNE, 1) is MissionPhase.ENTERING_OFFBOARD
    assert mission.see(AIRBORNE, 3) is MissionPhase.ENTERING_OFFBOARD
    assert mission.requests == [MissionRequest.OFFBOARD_MODE]
    assert mission.see(OFFBOARD, 4) is MissionPhase.FLYING
    assert mission.status.offboard_us == NOW + 4 * S


def test_lands_a_vehicle_that_refuses_offboard() -> None:
    mission = Mission(MissionPhase.ENTERING_OFFBOARD, requested_us=NOW)
    assert mission.see(AIRBORNE, 15.1) is MissionPhase.LANDING
    assert (mission.requests, mission.status.outcome) == ([MissionRequest.LAND], Outcome.REFUSED)
