"""Parts that go wrong in flight, in a process of their own, against a small vehicle in lockstep."""

import os
from pathlib import Path

import pytest

from flightstack.companion.console import Console
from flightstack.companion.flight import fly
from flightstack.companion.mission.records import Outcome
from flightstack.companion.piloting.in_worker import WorkerPilot, memory_bytes
from flightstack.companion.summary import FlightSummary
from tests.unit.flightstack.companion.piloting import bad_pilots
from tests.unit.flightstack.companion.piloting.bad_pilots import Answer, Turning
from tests.wire.companion.companion_trial import Trial
from tests.wire.fake_vehicle import Script

ROOM_BYTES = 300e6


def fly_with(trial: Trial, load: Turning) -> FlightSummary:
    limit = memory_bytes(os.getpid()) + ROOM_BYTES
    with trial.vehicle:
        return fly(
            trial.plan,
            lambda _: WorkerPilot.start(load, max_memory_bytes=limit),
            Console(verbosity=1, stream=trial.output),
        )


@pytest.mark.parametrize(
    "answer",
    [bad_pilots.raises, bad_pilots.exits, bad_pilots.dies, bad_pilots.leaks, bad_pilots.has_nan],
)
def test_a_part_that_fails_is_held_for_then_landed(tmp_path: Path, answer: Answer) -> None:
    trial = Trial(tmp_path, Script(gates=None), duration_s=20.0)
    summary = fly_with(trial, Turning(answer))
    assert (summary.outcome, summary.exit_code) == (Outcome.PART_FAILED, 1)
    assert not trial.vehicle.armed
    forward = [setpoint.vx for setpoint in trial.vehicle.setpoints()]
    assert forward.count(bad_pilots.FORWARD_M_S) == bad_pilots.GOOD_IMAGES
    assert trial.output.getvalue().count("warning: policy ") == 1
    assert summary.duration_s == pytest.approx(2.2, abs=0.11)


def test_one_bad_image_is_held_for_and_flown_on_from(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script())
    summary = fly_with(trial, Turning(bad_pilots.raises, bad_images=1))
    assert summary.outcome is Outcome.COMPLETED
    forward = [setpoint.vx for setpoint in trial.vehicle.setpoints()]
    begun = forward.index(bad_pilots.FORWARD_M_S)
    assert forward[begun : begun + 4] == [2.0, 2.0, 0.0, 2.0]


def test_in_lockstep_nobody_is_too_slow(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script(gates=None), duration_s=0.6)
    summary = fly_with(trial, Turning(bad_pilots.is_slow))
    assert summary.outcome is Outcome.COMPLETED
    assert "slow" not in trial.output.getvalue()
