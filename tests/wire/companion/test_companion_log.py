"""What a flight leaves behind: the log of both directions, and the gates in it."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from flightstack.companion.mission.records import Outcome
from tests.unit.flightstack.small_disk import small_disk
from tests.wire.companion.companion_trial import Trial, read_tlog
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


def test_records_each_image_and_what_each_member_said_of_it(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script(), record_images=True)
    summary = trial.fly()
    pictures = sorted((tmp_path / "flight.frames").iterdir())
    stamps_us = [int(picture.stem) for picture in pictures]
    assert stamps_us == [50_000 * k for k in range(summary.images)]
    assert {picture.name for picture in pictures} == {f"{us:012d}.png" for us in stamps_us}
    image = cv2.imread(str(pictures[0]), cv2.IMREAD_COLOR)
    assert image is not None
    assert image.shape == (64, 64, 3)
    assert image[5, 5].tolist() == [10, 20, 30]  # BGR
    arrays = [m for m in read_tlog(trial.plan.log) if m.get_type() == "DEBUG_FLOAT_ARRAY"]
    members = [m for m in arrays if m.name == "members"]
    assert {m.time_usec for m in members} == {m.time_usec for m in arrays if m.name == "decision"}
    assert {m.time_usec for m in members} <= set(stamps_us)
    assert members[0].data[:20] == [2, 0, 0, 0] * 5


def test_records_nothing_unless_asked_to(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script(gates=None), duration_s=1.0)
    trial.fly()
    assert [path.name for path in tmp_path.iterdir()] == ["flight.tlog"]


def test_flies_on_when_the_disk_is_full_and_says_so_once(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script(), record_images=True)
    with small_disk(100):
        summary = trial.fly()
    assert summary.outcome is Outcome.COMPLETED
    output = trial.output.getvalue()
    assert output.count("flight.tlog ends here: File too large") == 1
    assert output.count("flight.frames ends here: File too large") == 1
    assert sum(1 for _ in read_tlog(trial.plan.log)) == 0  # not even one second fits


def test_a_log_without_space_is_no_reason_not_to_fly(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script(gates=None), duration_s=1.0, log=Path("/dev/full"))
    assert trial.fly().outcome is Outcome.COMPLETED
    told = "warning: the log /dev/full ends here: No space left on device"
    assert trial.output.getvalue().count(told) == 1
