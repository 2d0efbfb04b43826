"""Each transition of the mission, without socket, thread or clock."""

from dataclasses import replace
from typing import Any

import pytest

from flightstack.companion.mission import RETRY_US, advance
from flightstack.companion.mission_state import MissionState, Outcome, Phase, Request, Situation
from flightstack.mavlink.px4 import Px4Mode
from flightstack.mavlink.telemetry import Course, CourseFailure, Landed, Telemetry

S = 1_000_000
NOW = 100 * S
READY = Telemetry(
    custom_mode=Px4Mode.LOITER,
    armable=True,
    landed=Landed.ON_GROUND,
    home_altitude_amsl_m=489.4,
    velocity_ned=(0.0, 0.0, 0.0),
)
AIRBORNE = replace(READY, armed=True, armable=False, landed=Landed.IN_AIR)
OFFBOARD = replace(AIRBORNE, custom_mode=Px4Mode.OFFBOARD)
COURSE = Course(gates_passed=2, gates_total=8)


class Mission:
    """A mission in some phase since NOW, and what it has asked for."""

    def __init__(self, phase: Phase = Phase.WAITING, **state: Any) -> None:
        entered = {"entered_us": NOW, "offboard_us": NOW if phase is Phase.FLYING else None}
        self.state = MissionState(phase=phase, **(entered | state))
        self.requests: list[Request] = []

    def see(
        self,
        vehicle: Telemetry,
        after_s: float = 0.0,
        *,
        stop: bool = False,
        frame_age_s: float = 0,
    ) -> Phase:
        now_us = NOW + round(after_s * S)
        beat_us = now_us if vehicle.heartbeat_us is None else vehicle.heartbeat_us
        situation = Situation(
            vehicle=replace(vehicle, heartbeat_us=beat_us),
            frame_us=now_us - round(frame_age_s * S),
            stop_requested=stop,
        )
        self.state, requests = advance(self.state, situation, now_us)
        self.requests += requests
        return self.state.phase


def test_streams_for_a_second_before_arming() -> None:
    mission = Mission()
    assert mission.see(READY, 0.95) is Phase.WAITING
    assert mission.see(READY, 1.0) is Phase.ARMING
    assert mission.requests == [Request.ARM]


def test_waits_until_the_vehicle_can_be_armed() -> None:
    mission = Mission()
    for second in range(1, 20):
        assert mission.see(replace(READY, armable=False), second) is Phase.WAITING
    assert mission.requests == []
    assert mission.see(READY, 20) is Phase.ARMING


def test_asks_for_a_home_that_is_not_told() -> None:
    mission = Mission()
    homeless = replace(READY, home_altitude_amsl_m=None)
    assert mission.see(homeless, 2) is Phase.WAITING
    assert mission.requests == []
    mission.see(homeless, 3)
    assert mission.requests == [Request.HOME_POSITION]
    assert mission.see(READY, 4) is Phase.ARMING


def test_leaves_a_mode_that_cannot_be_armed() -> None:
    mission = Mission()
    mission.see(replace(READY, armable=False, custom_mode=Px4Mode.POSITION), 2)
    assert mission.requests == [Request.HOLD_MODE]


def test_goes_on_from_a_vehicle_that_is_armed_already() -> None:
    mission = Mission()
    assert mission.see(replace(READY, armed=True), 1) is Phase.TAKING_OFF
    assert mission.requests == [Request.TAKE_OFF]


def test_goes_on_from_a_vehicle_that_holds_in_the_air() -> None:
    mission = Mission()
    assert mission.see(AIRBORNE, 1) is Phase.ENTERING_OFFBOARD
    assert mission.requests == [Request.OFFBOARD_MODE]


def test_does_not_take_a_vehicle_from_its_pilot() -> None:
    mission = Mission()
    assert mission.see(replace(AIRBORNE, custom_mode=Px4Mode.POSITION), 5) is Phase.WAITING
    assert mission.requests == []


def test_a_course_that_is_over_is_not_flown() -> None:
    mission = Mission()
    over = Course(gates_passed=8, gates_total=8, finished=True)
    assert mission.see(replace(READY, course=over), 2) is Phase.DONE
    assert mission.state.outcome is Outcome.COURSE_OVER


def test_arms_again_until_armed() -> None:
    mission = Mission(Phase.ARMING, requested_us=NOW)
    mission.see(READY, RETRY_US / S - 0.1)
    assert mission.requests == []
    mission.see(READY, RETRY_US / S)
    assert mission.requests == [Request.ARM]
    assert mission.see(replace(READY, armed=True), 4) is Phase.TAKING_OFF


def test_gives_up_a_vehicle_that_will_not_arm() -> None:
    mission = Mission(Phase.ARMING)
    assert mission.see(READY, 21) is Phase.LANDING
    assert mission.requests == [Request.DISARM]
    assert mission.see(READY, 22) is Phase.DONE
    assert mission.state.outcome is Outcome.REFUSED


def test_enters_offboard_once_it_hovers() -> None:
    mission = Mission(Phase.TAKING_OFF, requested_us=NOW)
    climbing = replace(AIRBORNE, custom_mode=Px4Mode.TAKEOFF, velocity_ned=(0.0, 0.0, -1.5))
    assert mission.see(climbing, 2) is Phase.TAKING_OFF
    overshooting = replace(AIRBORNE, velocity_ned=(0.0, 0.0, -0.5))
    assert mission.see(overshooting, 6) is Phase.TAKING_OFF
    assert mission.see(AIRBORNE, 7) is Phase.TAKING_OFF
    assert mission.see(AIRBORNE, 7.5) is Phase.TAKING_OFF
    assert mission.see(AIRBORNE, 8) is Phase.ENTERING_OFFBOARD
    assert mission.requests == [Request.OFFBOARD_MODE]


def test_an_estimate_that_never_rests_does_not_hold_it_up() -> None:
    mission = Mission(Phase.TAKING_OFF, confirmed=True)
    restless = replace(AIRBORNE, velocity_ned=(0.4, 0.0, 0.0))
    assert mission.see(restless, 20) is Phase.TAKING_OFF
    assert mission.see(restless, 20.1) is Phase.ENTERING_OFFBOARD


def test_takes_off_again_until_the_mode_shows() -> None:
    mission = Mission(Phase.TAKING_OFF, requested_us=NOW)
    armed = replace(READY, armed=True)
    mission.see(armed, 2.9)
    mission.see(armed, 3.0)
    assert mission.requests == [Request.TAKE_OFF]


def test_a_vehicle_that_disarms_before_it_lifts_off_has_refused() -> None:
    mission = Mission(Phase.TAKING_OFF)
    mission.see(READY, 11)
    assert mission.state.outcome is Outcome.REFUSED


@pytest.mark.parametrize("phase", [Phase.TAKING_OFF, Phase.ENTERING_OFFBOARD, Phase.FLYING])
def test_hands_off_when_somebody_changes_the_mode(phase: Phase) -> None:
    mission = Mission(phase, confirmed=True)
    assert mission.see(replace(AIRBORNE, custom_mode=Px4Mode.POSITION), 1) is Phase.TAKEN_OVER
    assert (mission.requests, mission.state.outcome) == ([], Outcome.TAKEN_OVER)


def test_offboard_is_believed_from_the_heartbeat_alone() -> None:
    mission = Mission(Phase.ENTERING_OFFBOARD, requested_us=NOW)
    assert mission.see(AIRBORNE, 1) is Phase.ENTERING_OFFBOARD
    assert mission.see(AIRBORNE, 3) is Phase.ENTERING_OFFBOARD
    assert mission.requests == [Request.OFFBOARD_MODE]
    assert mission.see(OFFBOARD, 4) is Phase.FLYING
    assert mission.state.offboard_us == NOW + 4 * S


def test_lands_a_vehicle_that_refuses_offboard() -> None:
    mission = Mission(Phase.ENTERING_OFFBOARD, requested_us=NOW)
    assert mission.see(AIRBORNE, 15.1) is Phase.LANDING
    assert (mission.requests, mission.state.outcome) == ([Request.LAND], Outcome.REFUSED)


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
    mission = Mission(Phase.FLYING)
    assert mission.see(replace(OFFBOARD, course=COURSE), 1) is Phase.FLYING
    assert mission.see(replace(OFFBOARD, course=course), 2) is Phase.LANDING
    assert (mission.requests, mission.state.outcome) == ([Request.LAND], outcome)
    assert mission.state.ended_us == NOW + 2 * S


def test_a_collision_that_disarms_is_a_collision() -> None:
    mission = Mission(Phase.FLYING)
    crashed = replace(COURSE, failed=True, failure=CourseFailure.COLLISION)
    mission.see(replace(READY, course=crashed), 1)
    assert mission.state.outcome is Outcome.COLLISION


@pytest.mark.parametrize(
    ("course", "outcome"), [(Course(), Outcome.COMPLETED), (COURSE, Outcome.TIMEOUT)]
)
def test_duration_ends_the_flight(course: Course, outcome: Outcome) -> None:
    mission = Mission(Phase.FLYING, duration_us=10 * S)
    assert mission.see(replace(OFFBOARD, course=course), 9.95) is Phase.FLYING
    assert mission.see(replace(OFFBOARD, course=course), 10) is Phase.LANDING
    assert mission.state.outcome is outcome


IN_FLIGHT = [Phase.TAKING_OFF, Phase.ENTERING_OFFBOARD, Phase.FLYING]


@pytest.mark.parametrize("phase", IN_FLIGHT)
def test_a_stop_lands_first(phase: Phase) -> None:
    mission = Mission(phase)
    assert mission.see(OFFBOARD, 1, stop=True) is Phase.LANDING
    assert (mission.requests, mission.state.outcome) == ([Request.LAND], Outcome.INTERRUPTED)


def test_a_stop_while_waiting_ends_at_once() -> None:
    mission = Mission()
    assert mission.see(READY, 1, stop=True) is Phase.DONE
    assert (mission.requests, mission.state.outcome) == ([], Outcome.INTERRUPTED)


def test_a_stop_while_arming_leaves_it_disarmed() -> None:
    mission = Mission(Phase.ARMING)
    assert mission.see(READY, 1, stop=True) is Phase.LANDING
    assert mission.requests == [Request.DISARM]
    assert mission.see(READY, 2, stop=True) is Phase.DONE


@pytest.mark.parametrize("phase", IN_FLIGHT)
def test_lands_when_no_frames_come(phase: Phase) -> None:
    mission = Mission(phase, confirmed=True)
    vehicle = OFFBOARD if phase is Phase.FLYING else AIRBORNE
    assert mission.see(vehicle, 0.1, frame_age_s=2.5) is not Phase.LANDING
    assert mission.see(vehicle, 0.1, frame_age_s=2.6) is Phase.LANDING
    assert mission.state.outcome is Outcome.CAMERA_LOST


def test_lands_when_heartbeats_stop() -> None:
    mission = Mission(Phase.FLYING)
    assert mission.see(replace(OFFBOARD, heartbeat_us=NOW), 3.0) is Phase.FLYING
    assert mission.see(replace(OFFBOARD, heartbeat_us=NOW), 3.1) is Phase.LANDING
    assert mission.state.outcome is Outcome.LINK_LOST


def test_taken_over_ends_when_the_vehicle_is_disarmed() -> None:
    mission = Mission(Phase.TAKEN_OVER, outcome=Outcome.TAKEN_OVER)
    flown = replace(AIRBORNE, custom_mode=Px4Mode.POSITION)
    assert mission.see(flown, 500, frame_age_s=9) is Phase.TAKEN_OVER
    assert mission.see(READY, 501) is Phase.DONE
    assert (mission.requests, mission.state.outcome) == ([], Outcome.TAKEN_OVER)


def test_taken_over_ends_with_a_signal_or_the_duration() -> None:
    flown = replace(AIRBORNE, custom_mode=Px4Mode.POSITION)
    assert (
        Mission(Phase.TAKEN_OVER, outcome=Outcome.TAKEN_OVER).see(flown, 1, stop=True) is Phase.DONE
    )
    timed = Mission(Phase.TAKEN_OVER, offboard_us=NOW, duration_us=5 * S)
    assert timed.see(flown, 4) is Phase.TAKEN_OVER
    assert timed.see(flown, 5) is Phase.DONE
    assert timed.requests == []


def test_a_failsafe_that_recovers_is_landed() -> None:
    mission = Mission(Phase.TAKEN_OVER, outcome=Outcome.TAKEN_OVER)
    assert mission.see(OFFBOARD, 2) is Phase.LANDING
    assert (mission.requests, mission.state.outcome) == ([Request.LAND], Outcome.TAKEN_OVER)


def landing(**state: Any) -> Mission:
    return Mission(Phase.LANDING, requested_us=NOW, outcome=Outcome.COMPLETED, **state)


def test_lands_again_until_the_mode_shows() -> None:
    mission = landing()
    mission.see(OFFBOARD, 2.9)
    mission.see(OFFBOARD, 3.0)
    assert mission.requests == [Request.LAND]
    mission.see(replace(AIRBORNE, custom_mode=Px4Mode.LAND), 4)
    mission.see(replace(AIRBORNE, custom_mode=Px4Mode.POSITION), 10)  # somebody saves it
    assert mission.requests == [Request.LAND]


def test_done_when_disarmed() -> None:
    mission = landing()
    on_ground = replace(READY, armed=True, landed_us=NOW + 9 * S, custom_mode=Px4Mode.LAND)
    assert mission.see(on_ground, 10) is Phase.LANDING
    assert mission.see(READY, 12) is Phase.DONE
    assert (mission.requests, mission.state.outcome) == ([], Outcome.COMPLETED)


def test_an_old_heartbeat_does_not_end_the_landing() -> None:
    mission = landing()
    assert mission.see(replace(READY, heartbeat_us=NOW), 0.5) is Phase.LANDING
    assert mission.see(replace(READY, heartbeat_us=NOW + S), 1.1) is Phase.DONE


def test_disarms_a_vehicle_that_stays_armed_on_the_ground() -> None:
    mission = landing()
    on_ground = replace(READY, armed=True, landed_us=NOW + 9 * S)
    mission.see(on_ground, 12.9)
    assert mission.requests == []
    mission.see(on_ground, 13)
    assert mission.requests == [Request.DISARM]


def test_a_landing_without_end_is_not_a_completed_flight() -> None:
    mission = landing(confirmed=True)
    assert mission.see(OFFBOARD, 121) is Phase.DONE
    assert mission.state.outcome is Outcome.REFUSED


def test_what_ended_the_flight_first_stays_the_reason() -> None:
    mission = Mission(Phase.TAKEN_OVER, outcome=Outcome.TAKEN_OVER, ended_us=NOW)
    mission.see(OFFBOARD, 3, stop=True)
    assert (mission.state.outcome, mission.state.ended_us) == (Outcome.TAKEN_OVER, NOW)


def test_done_stays_done() -> None:
    mission = Mission(Phase.DONE, outcome=Outcome.COMPLETED)
    assert mission.see(OFFBOARD, 999, stop=True, frame_age_s=99) is Phase.DONE
    assert mission.requests == []
