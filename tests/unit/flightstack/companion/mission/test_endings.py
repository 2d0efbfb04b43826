"""From flying to done: what ends a flight, and how the vehicle comes down."""

from dataclasses import replace
from typing import Any

import pytest

from flightstack.companion.mission.records import MissionPhase, MissionRequest, Outcome
from flightstack.mavlink.telemetry import Course, CourseFailure, Telemetry
from flightstack.px4_modes import Px4Mode
from tests.unit.flightstack.companion.mission.made_mission import (
    AIRBORNE,
    COURSE,
    IN_FLIGHT,
    NOW,
    OFFBOARD,
    READY,
    UNSEEN_US,
    Mission,
    S,
)

UNSEEN = replace(OFFBOARD, heartbeat_us=UNSEEN_US)  # since it fell silent


@pytest.mark.parametrize(
    ("course", "outcome"),
    [
        (replace(COURSE, finished=True), Outcome.COMPLETED),
        (replace(COURSE, failed=True, failure=CourseFailure.COLLISION), Outcome.COLLISION),
        (replace(COURSE, failed=True, failure=CourseFailure.MISSED_GATE), Outcome.MISSED_GATE),
        (replace(COURSE, failed=True), Outcome.MISSED_GATE),
    ],
)
def test_lands_when_the_referee_ends_the_course(course: Course, outcome: Outcome) -> None:
    mission = Mission(MissionPhase.FLYING)
    assert mission.see(replace(OFFBOARD, course=COURSE), 1) is MissionPhase.FLYING
    assert mission.see(replace(OFFBOARD, course=course), 2) is MissionPhase.LANDING
    assert (mission.requests, mission.status.outcome) == ([MissionRequest.LAND], outcome)
    assert mission.status.ended_us == NOW + 2 * S


def test_a_collision_that_disarms_is_a_collision() -> None:
    mission = Mission(MissionPhase.FLYING)
    crashed = replace(COURSE, failed=True, failure=CourseFailure.COLLISION)
    mission.see(replace(READY, course=crashed), 1)
    assert mission.status.outcome is Outcome.COLLISION


@pytest.mark.parametrize(
    ("course", "outcome"), [(Course(), Outcome.COMPLETED), (COURSE, Outcome.TIMEOUT)]
)
def test_duration_ends_the_flight(course: Course, outcome: Outcome) -> None:
    mission = Mission(MissionPhase.FLYING, duration_us=10 * S)
    assert mission.see(replace(OFFBOARD, course=course), 9.95) is MissionPhase.FLYING
    assert mission.see(replace(OFFBOARD, course=course), 10) is MissionPhase.LANDING
    assert mission.status.outcome is outcome


def test_one_that_is_said_to_restart_again_while_it_flies_is_still_called_to_land() -> None:
    mission = Mission(MissionPhase.FLYING)
    mission.see(OFFBOARD, 5)
    for second in (-99, -98, -97):
        assert mission.see(UNSEEN, second, restarted_us=NOW) is MissionPhase.REACHING
    assert set(mission.requests) == {MissionRequest.LAND}
    assert mission.see(OFFBOARD, -96) is MissionPhase.LANDING


@pytest.mark.parametrize("phase", IN_FLIGHT)
def test_a_stop_lands_first(phase: MissionPhase) -> None:
    mission = Mission(phase)
    assert mission.see(OFFBOARD, 1, stop=True) is MissionPhase.LANDING
    assert (mission.requests, mission.status.outcome) == (
        [MissionRequest.LAND],
        Outcome.INTERRUPTED,
    )


def test_a_stop_while_waiting_ends_at_once() -> None:
    mission = Mission()
    assert mission.see(READY, 1, stop=True) is MissionPhase.DONE
    assert (mission.requests, mission.status.outcome) == ([], Outcome.INTERRUPTED)


def test_a_stop_while_arming_leaves_it_disarmed() -> None:
    mission = Mission(MissionPhase.ARMING)
    assert mission.see(READY, 1, stop=True) is MissionPhase.LANDING
    assert mission.requests == [MissionRequest.DISARM]
    assert mission.see(READY, 2, stop=True) is MissionPhase.DONE


@pytest.mark.parametrize("phase", IN_FLIGHT)
def test_lands_when_no_images_come(phase: MissionPhase) -> None:
    mission = Mission(phase, confirmed=True)
    vehicle = OFFBOARD if phase is MissionPhase.FLYING else AIRBORNE
    assert mission.see(vehicle, 0.1, image_age_s=2.5) is not MissionPhase.LANDING
    assert mission.see(vehicle, 0.1, image_age_s=2.6) is MissionPhase.LANDING
    assert mission.status.outcome is Outcome.CAMERA_LOST


def test_lands_when_heartbeats_alone_stop_for_long() -> None:
    mission = Mission(MissionPhase.FLYING)
    assert mission.see(replace(OFFBOARD, heartbeat_us=NOW), 10.0) is MissionPhase.FLYING
    assert mission.see(replace(OFFBOARD, heartbeat_us=NOW), 10.1) is MissionPhase.LANDING
    assert mission.status.outcome is Outcome.LINK_LOST


def test_taken_over_ends_when_the_vehicle_is_disarmed() -> None:
    mission = Mission(MissionPhase.TAKEN_OVER, outcome=Outcome.TAKEN_OVER)
    flown = replace(AIRBORNE, custom_mode=Px4Mode.POSITION)
    assert mission.see(flown, 500, image_age_s=9) is MissionPhase.TAKEN_OVER
    assert mission.see(READY, 501) is MissionPhase.DONE
    assert (mission.requests, mission.status.outcome) == ([], Outcome.TAKEN_OVER)


def test_taken_over_ends_with_a_signal_or_the_duration() -> None:
    flown = replace(AIRBORNE, custom_mode=Px4Mode.POSITION)
    assert (
        Mission(MissionPhase.TAKEN_OVER, outcome=Outcome.TAKEN_OVER).see(flown, 1, stop=True)
        is MissionPhase.DONE
    )
    timed = Mission(MissionPhase.TAKEN_OVER, offboard_us=NOW, duration_us=5 * S)
    assert timed.see(flown, 4) is MissionPhase.TAKEN_OVER
    assert timed.see(flown, 5) is MissionPhase.DONE
    assert timed.requests == []


def test_a_failsafe_that_recovers_is_landed() -> None:
    mission = Mission(MissionPhase.TAKEN_OVER, outcome=Outcome.TAKEN_OVER)
    assert mission.see(OFFBOARD, 2) is MissionPhase.LANDING
    assert (mission.requests, mission.status.outcome) == ([MissionRequest.LAND], Outcome.TAKEN_OVER)


def landing(**status: Any) -> Mission:
    return Mission(MissionPhase.LANDING, requested_us=NOW, outcome=Outcome.COMPLETED, **status)


def test_lands_again_until_the_mode_shows() -> None:
    mission = landing()
    mission.see(OFFBOARD, 2.9)
    mission.see(OFFBOARD, 3.0)
    assert mission.requests == [MissionRequest.LAND]
    mission.see(replace(AIRBORNE, custom_mode=Px4Mode.LAND), 4)
    mission.see(replace(AIRBORNE, custom_mode=Px4Mode.POSITION), 10)  # somebody saves it
    assert mission.requests == [MissionRequest.LAND]


def test_done_when_disarmed() -> None:
    mission = landing()
    on_ground = replace(READY, armed=True, landed_us=NOW + 9 * S, custom_mode=Px4Mode.LAND)
    assert mission.see(on_ground, 10) is MissionPhase.LANDING
    assert mission.see(READY, 12) is MissionPhase.DONE
    assert (mission.requests, mission.status.outcome) == ([], Outcome.COMPLETED)


def test_an_old_heartbeat_does_not_end_the_landing() -> None:
    mission = landing()
    assert mission.see(replace(READY, heartbeat_us=NOW), 0.5) is MissionPhase.LANDING
    assert mission.see(replace(READY, heartbeat_us=NOW + S), 1.1) is MissionPhase.DONE


def test_disarms_a_vehicle_that_stays_armed_on_the_ground() -> None:
    mission = landing()
    on_ground = replace(READY, armed=True, landed_us=NOW + 9 * S)
    mission.see(on_ground, 12.9)
    assert mission.requests == []
    mission.see(on_ground, 13)
    assert mission.requests == [MissionRequest.DISARM]


def test_a_landing_without_end_is_not_a_completed_flight() -> None:
    mission = landing(confirmed=True)
    assert mission.see(OFFBOARD, 121) is MissionPhase.DONE
    assert mission.status.outcome is Outcome.REFUSED


def test_what_ended_the_flight_first_stays_the_reason() -> None:
    mission = Mission(MissionPhase.TAKEN_OVER, outcome=Outcome.TAKEN_OVER, ended_us=NOW)
    mission.see(OFFBOARD, 3, stop=True)
    assert (mission.status.outcome, mission.status.ended_us) == (Outcome.TAKEN_OVER, NOW)


def test_done_stays_done() -> None:
    mission = Mission(MissionPhase.DONE, outcome=Outcome.COMPLETED)
    assert mission.see(OFFBOARD, 999, stop=True, image_age_s=99) is MissionPhase.DONE
    assert mission.requests == []


def test_without_a_gate_for_long_the_course_is_given_up() -> None:
    mission = Mission(MissionPhase.FLYING, gate_timeout_us=10 * S)
    assert mission.see(replace(OFFBOARD, course=Course(gates_total=8)), 9.95) is MissionPhase.FLYING
    assert mission.see(replace(OFFBOARD, course=COURSE), 9.96) is MissionPhase.FLYING
    assert mission.see(replace(OFFBOARD, course=COURSE), 19.95) is MissionPhase.FLYING
    assert mission.see(replace(OFFBOARD, course=COURSE), 19.96) is MissionPhase.LANDING
    assert mission.status.outcome is Outcome.TIMEOUT


@pytest.mark.parametrize(
    "vehicle",
    [
        replace(OFFBOARD, course=replace(COURSE, failed=True)),
        replace(AIRBORNE, course=COURSE),  # somebody took over
    ],
)
def test_a_flight_of_a_simulation_ends_in_the_air(vehicle: Telemetry) -> None:
    mission = Mission(MissionPhase.FLYING, lands=False)
    assert mission.see(vehicle, 1) is MissionPhase.DONE
    assert mission.requests == []
    assert mission.status.outcome is not None


def test_a_silent_vehicle_is_called_until_it_is_heard_and_lands() -> None:
    mission = Mission(MissionPhase.FLYING)
    assert mission.see(UNSEEN, 1, silent=True) is MissionPhase.REACHING
    assert mission.requests == [MissionRequest.LAND]
    assert mission.status.ended_us == NOW + S
    for second in range(2, 8):
        assert mission.see(UNSEEN, second, silent=True) is MissionPhase.REACHING
    assert mission.requests == [MissionRequest.LAND] * 3
    assert mission.see(UNSEEN, 7.5) is MissionPhase.REACHING  # heard, but not its heartbeat
    assert mission.see(OFFBOARD, 8) is MissionPhase.LANDING
    assert mission.requests[3:] == [MissionRequest.LAND]
    assert mission.see(READY, 20) is MissionPhase.DONE
    assert (mission.status.outcome, mission.status.ended_us) == (Outcome.LINK_LOST, NOW + S)


def test_a_silent_vehicle_is_called_for_minutes_not_for_ever() -> None:
    mission = Mission(MissionPhase.FLYING)
    assert mission.see(UNSEEN, 1, silent=True) is MissionPhase.REACHING
    assert mission.see(UNSEEN, 301, silent=True) is MissionPhase.REACHING
    assert mission.see(UNSEEN, 302, silent=True) is MissionPhase.DONE
    assert mission.status.outcome is Outcome.LINK_LOST


def test_a_vehicle_that_has_landed_itself_meanwhile_is_done() -> None:
    mission = Mission(MissionPhase.REACHING, outcome=Outcome.LINK_LOST)
    assert mission.see(READY, 1) is MissionPhase.DONE
    assert mission.requests == []


def test_a_vehicle_that_somebody_has_taken_meanwhile_is_left_to_them() -> None:
    mission = Mission(MissionPhase.REACHING, outcome=Outcome.LINK_LOST)
    flown = replace(AIRBORNE, custom_mode=Px4Mode.POSITION)
    assert mission.see(flown, 1) is MissionPhase.TAKEN_OVER
    assert mission.requests == []


def test_an_end_that_has_closed_for_good_is_not_called() -> None:
    mission = Mission(MissionPhase.FLYING)
    assert mission.see(UNSEEN, 1, silent=True, gone=True) is MissionPhase.REACHING
    assert mission.see(UNSEEN, 1, silent=True, gone=True) is MissionPhase.DONE


def test_a_silent_vehicle_that_was_not_touched_is_left_alone() -> None:
    waiting = Mission()
    assert waiting.see(READY, 1, silent=True) is MissionPhase.DONE
    assert (waiting.status.outcome, waiting.requests) == (Outcome.LINK_LOST, [])
    simulated = Mission(MissionPhase.FLYING, lands=False)
    assert simulated.see(UNSEEN, 1, silent=True) is MissionPhase.DONE


def test_a_vehicle_that_restarts_is_said_to_have_restarted() -> None:
    mission = Mission(MissionPhase.FLYING)
    mission.see(OFFBOARD, 5)
    assert mission.see(UNSEEN, -99, restarted_us=NOW + 5 * S) is MissionPhase.REACHING
    assert mission.status.ended_us == NOW + 5 * S
    assert mission.see(READY, -98) is MissionPhase.DONE
    assert mission.status.outcome is Outcome.RESTARTED


@pytest.mark.parametrize("phase", IN_FLIGHT)
def test_a_vehicle_that_somebody_else_steers_is_let_go(phase: MissionPhase) -> None:
    mission = Mission(phase)
    assert mission.see(OFFBOARD, 1, other=True) is MissionPhase.DONE
    assert (mission.requests, mission.status.outcome) == ([], Outcome.OTHER_PILOT)
