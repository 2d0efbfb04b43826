"""What a flight leaves behind: the log of both directions, and the gates in it."""

from pathlib import Path

import numpy as np
import pytest

from flightstack.companion.mission_state import Outcome
from tests.wire.companion_trial import Trial, read_tlog
from tests.wire.fake_vehicle import Script


def test_the_log_holds_both_directions_in_vehicle_time(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script())
    summary = trial.fly()
    records = list(read_tlog(trial.plan.log))
    setpoints = [m for m in records if m.get_type() == "SET_POSITION_TARGET_LOCAL_NED"]
    assert len(setpoints) == summary.setpoints
    gaps = np.diff([m._timestamp for m in setpoints])
    assert np.median(gaps) == pytest.approx(0.05, abs=1e-3)
    assert {m.get_srcComponent() for m in records} == {1, 25, 100, 191}


def test_the_log_lists_the_referees_gates(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script(gates=3))
    assert trial.fly().outcome is Outcome.COMPLETED
    items = [m for m in read_tlog(trial.plan.log) if m.get_type() == "MISSION_ITEM_INT"]
    assert [(m.get_srcComponent(), m.seq, m.x) for m in items] == [
        (25, seq, 10_000 * (seq + 1)) for seq in range(3)
    ]


def test_a_referee_that_lists_no_gates_holds_nothing_up(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script(lists_gates=False))
    assert trial.fly().outcome is Outcome.COMPLETED
    kinds = [m.get_type() for m in trial.vehicle.received]
    assert kinds.count("MISSION_REQUEST_LIST") == 4


def test_without_referee_nobody_is_asked_for_gates(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script(gates=None), duration_s=1.0)
    trial.fly()
    assert "MISSION_REQUEST_LIST" not in {m.get_type() for m in trial.vehicle.received}
