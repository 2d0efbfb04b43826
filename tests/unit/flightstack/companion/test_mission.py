"""From waiting to flying: each transition of the mission, without socket, thread or clock."""

from dataclasses import replace

import pytest

from flightstack.companion.mission import RETRY_US
from flightstack.companion.mission_state import Outcome, Phase, Request
from flightstack.mavlink.telemetry import Course
from flightstack.px4_modes import Px4Mode
from tests.unit.flightstack.companion.made_mission import AIRBORNE, NOW, OFFBOARD, READY, Mission, S


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
