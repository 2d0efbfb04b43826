"""A vehicle that somebody else has, or has left: the companion does not take it by itself."""

from pathlib import Path

from pymavlink.dialects.v20 import common

from flightstack.companion.mission.records import Outcome
from flightstack.px4_modes import Px4Mode
from tests.wire.companion.companion_trial import Trial
from tests.wire.fake_vehicle import Script


def test_a_second_companion_does_not_arm(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script(other_companion=True))
    summary = trial.fly()
    assert (summary.outcome, summary.exit_code) == (Outcome.OTHER_PILOT, 1)
    assert common.MAV_CMD_COMPONENT_ARM_DISARM not in trial.vehicle.commands()
    assert "another companion beats as ours does: see --take-over" in trial.output.getvalue()


def test_told_to_it_takes_over(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script(other_companion=True), takes_over=True)
    summary = trial.fly()
    assert summary.outcome is Outcome.COMPLETED


def test_a_landed_vehicle_that_was_left_armed_is_disarmed(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script())
    trial.vehicle.armed = True
    summary = trial.fly()
    assert (summary.outcome, summary.exit_code) == (Outcome.FOUND_ARMED, 1)
    assert not trial.vehicle.armed
    assert trial.vehicle.takeoff_amsl_m is None


def test_a_vehicle_that_was_left_in_the_air_is_landed(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script())
    vehicle = trial.vehicle
    vehicle.armed, vehicle.mode = True, Px4Mode.OFFBOARD
    vehicle.landed = common.MAV_LANDED_STATE_IN_AIR
    summary = trial.fly()
    assert summary.outcome is Outcome.FOUND_ARMED
    assert not vehicle.armed
    assert {setpoint.vx for setpoint in vehicle.setpoints()} == {0.0}
