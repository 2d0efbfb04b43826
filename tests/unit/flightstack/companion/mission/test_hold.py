"""One hold: who raises it, which of several counts, and what it ends the flight by."""

from dataclasses import replace

import pytest

from flightstack.companion.mission.hold import hold_for_camera
from flightstack.companion.mission.records import Hold, MissionPhase, MissionRequest, Outcome
from tests.unit.flightstack.companion.mission.made_mission import (
    IN_FLIGHT,
    NOW,
    OFFBOARD,
    Mission,
    S,
)

UNFIT = Hold(reason=Outcome.MISSED_GATE, since_us=NOW, lands_after_us=5 * S)


def test_a_camera_holds_after_half_a_second_and_lands_two_later() -> None:
    assert hold_for_camera(NOW, NOW + S // 2 - 1) is None
    hold = hold_for_camera(NOW, NOW + S // 2)
    assert hold == Hold(reason=Outcome.CAMERA_LOST, since_us=NOW + S // 2, lands_after_us=2 * S)
    assert hold.lands_us == NOW + 5 * S // 2


def test_a_hold_ends_with_its_reason() -> None:
    mission = Mission(MissionPhase.FLYING)
    mission.see(OFFBOARD, 1, image_age_s=0.6)
    assert mission.status.hold is not None
    mission.see(OFFBOARD, 2, image_age_s=0.0)
    assert mission.status.hold is None
    assert mission.status.phase is MissionPhase.FLYING


@pytest.mark.parametrize("phase", IN_FLIGHT)
def test_whoever_raises_a_hold_has_the_vehicle_landed_when_it_lasts(phase: MissionPhase) -> None:
    mission = Mission(phase)
    mission.see(OFFBOARD, 4.9, hold=UNFIT)
    assert mission.status.hold == UNFIT
    assert mission.see(OFFBOARD, 5.0, hold=UNFIT) is not MissionPhase.LANDING
    assert mission.see(OFFBOARD, 5.1, hold=UNFIT) is MissionPhase.LANDING
    assert mission.requests[-1] is MissionRequest.LAND
    assert mission.status.outcome is UNFIT.reason


def test_of_two_holds_the_one_that_lands_first_counts() -> None:
    mission = Mission(MissionPhase.FLYING)
    mission.see(OFFBOARD, 1, image_age_s=1.0, hold=UNFIT)
    assert mission.status.hold is not None
    assert mission.status.hold.reason is Outcome.CAMERA_LOST
    mission.see(OFFBOARD, 1, image_age_s=1.0, hold=replace(UNFIT, lands_after_us=S))
    assert mission.status.hold.reason is UNFIT.reason


def test_a_hold_does_not_touch_a_vehicle_that_others_steer() -> None:
    mission = Mission(MissionPhase.TAKEN_OVER, outcome=Outcome.TAKEN_OVER)
    assert mission.see(replace(OFFBOARD, custom_mode=0), 60, hold=UNFIT) is MissionPhase.TAKEN_OVER
    assert mission.requests == []
