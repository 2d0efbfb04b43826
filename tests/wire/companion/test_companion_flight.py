"""The companion against a small vehicle in lockstep, over real UDP and HTTP."""

import json
import math
import os
import signal
import threading
from pathlib import Path

import cv2
import numpy as np
import pytest
from pymavlink.dialects.v20 import common

from flightstack.companion.console import Console
from flightstack.companion.flight import fly
from flightstack.companion.mission.records import Outcome
from flightstack.companion.opening.steps import FlightPlan
from flightstack.errors import LinkError
from flightstack.mavlink.endpoint import parse_endpoint
from tests.wire.companion.companion_trial import (
    FORWARD_M_S,
    Trial,
    free_port,
    guarded,
    read_tlog,
)
from tests.wire.fake_vehicle import HOME_AMSL_M, Script


def test_flies_the_course_lands_and_disarms(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script())
    summary = trial.fly()
    assert summary.outcome is Outcome.COMPLETED
    assert (summary.gates_passed, summary.gates_total, summary.exit_code) == (3, 3, 0)
    assert not trial.vehicle.armed
    assert trial.vehicle.takeoff_amsl_m == pytest.approx(HOME_AMSL_M + 3.0, abs=1e-3)
    assert summary.duration_s == pytest.approx(1.5, abs=1.0)
    assert "gate 3/3" in trial.output.getvalue()


def test_answers_each_image_with_one_setpoint(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script())
    summary = trial.fly()
    setpoints = trial.vehicle.setpoints()
    stamps = [setpoint.time_boot_ms for setpoint in setpoints]
    assert stamps == list(range(0, 50 * len(stamps), 50))
    assert summary.setpoints == summary.images == len(stamps)
    assert {(s.coordinate_frame, s.type_mask) for s in setpoints} == {(8, 0x5C7)}
    moving = [s.time_boot_ms for s in setpoints if s.vx]
    assert moving == [image.stamp_us // 1000 for image in trial.pilot.images]
    assert all(image.rgb[0, 0].tolist() == [30, 20, 10] for image in trial.pilot.images)


def test_identifies_as_the_vehicles_companion(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script())
    trial.fly()
    sources = {(m.get_srcSystem(), m.get_srcComponent()) for m in trial.vehicle.received}
    beats = [m for m in trial.vehicle.received if m.get_type() == "HEARTBEAT"]
    assert sources == {(1, 191)}
    assert {(beat.type, beat.autopilot) for beat in beats} == {(18, 8)}
    assert len(beats) >= trial.vehicle.time_us // 1_000_000


def test_explains_each_decision(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script())
    trial.fly()
    arrays = [m for m in trial.vehicle.received if m.get_type() == "DEBUG_FLOAT_ARRAY"]
    named = [m for m in trial.vehicle.received if m.get_type() == "NAMED_VALUE_FLOAT"]
    assert [m.time_usec for m in arrays] == [image.stamp_us for image in trial.pilot.images]
    assert arrays[0].data[24:28] == [FORWARD_M_S, 0, 0, 0]
    assert named[0].name == "unc_alea"
    assert named[0].value == pytest.approx(0.3 * math.sqrt(3))


def test_two_flights_in_lockstep_are_the_same(tmp_path: Path) -> None:
    flights = []
    for name in ("one", "two"):
        (tmp_path / name).mkdir()
        trial = Trial(tmp_path / name, Script())
        trial.fly()
        sent = [m for m in trial.vehicle.received if m.get_type() != "HEARTBEAT"]
        flights.append([m.get_msgbuf()[10:-2] for m in sent if m.get_type() != "COMMAND_LONG"])
    assert flights[0] == flights[1]


def test_speed_scale_multiplies_the_command(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script(), speed_scale=0.5)
    trial.fly()
    assert {s.vx for s in trial.vehicle.setpoints()} == {0.0, 0.5 * FORWARD_M_S}


def test_a_missed_gate_ends_the_flight(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script(missed_gate=True))
    summary = trial.fly()
    assert (summary.outcome, summary.exit_code) == (Outcome.MISSED_GATE, 1)
    assert summary.gates_passed == 1
    assert not trial.vehicle.armed
    assert "Missed gate 1: 2.1 m right" in trial.output.getvalue()


def test_without_referee_it_flies_for_its_duration(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script(gates=None), duration_s=2.0)
    summary = trial.fly()
    assert (summary.outcome, summary.exit_code) == (Outcome.COMPLETED, 0)
    assert summary.duration_s == pytest.approx(2.0)
    assert json.loads(summary.to_json(model="none", strategy="forward"))["gates_total"] is None


def test_an_unfinished_course_times_out(tmp_path: Path) -> None:
    summary = Trial(tmp_path, Script(gates=100), duration_s=1.0).fly()
    assert (summary.outcome, summary.exit_code) == (Outcome.TIMEOUT, 1)


def test_lost_commands_are_sent_again(tmp_path: Path) -> None:
    lost = {
        common.MAV_CMD_COMPONENT_ARM_DISARM,
        common.MAV_CMD_NAV_TAKEOFF,
        common.MAV_CMD_DO_SET_MODE,
        common.MAV_CMD_NAV_LAND,
        common.MAV_CMD_REQUEST_MESSAGE,
    }
    trial = Trial(tmp_path, Script(ignored_commands=lost))
    assert trial.fly().outcome is Outcome.COMPLETED
    assert not trial.vehicle.script.ignored_commands


def test_hands_off_when_the_vehicle_leaves_offboard(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script(gates=None, leave_offboard_after=40), duration_s=4.0)
    summary = trial.fly()
    assert (summary.outcome, summary.exit_code) == (Outcome.TAKEN_OVER, 1)
    assert common.MAV_CMD_NAV_LAND not in trial.vehicle.commands()
    assert trial.vehicle.setpoints()[-1].vx == 0


def test_holds_then_lands_when_images_stop(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script(gates=None, images_stop_after=40))
    summary = trial.fly()
    assert (summary.outcome, summary.exit_code) == (Outcome.CAMERA_LOST, 3)
    assert not trial.vehicle.armed
    held = [s for s in trial.vehicle.setpoints() if s.time_boot_ms * 1000 % 50_000 == 0][-20:]
    assert {s.vx for s in held} == {0.0}


def test_a_stream_that_breaks_is_opened_again(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script(stream_breaks_after=30))
    assert trial.fly().outcome is Outcome.COMPLETED


def test_a_silent_vehicle_is_called_then_given_up(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script(gates=None, silent_after=30), reach_s=4.0)
    summary = trial.fly()
    assert (summary.outcome, summary.exit_code) == (Outcome.LINK_LOST, 3)
    landings = trial.vehicle.commands().count(common.MAV_CMD_NAV_LAND)
    assert landings >= 2  # again and again
    assert "trying to reach the vehicle (link lost)" in trial.output.getvalue()
    assert sum(1 for _ in read_tlog(trial.plan.log)) > 100


def test_never_sends_what_is_not_finite(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script(gates=None), duration_s=9.0)
    trial.pilot.command[1] = math.nan
    summary = trial.fly()
    assert (summary.outcome, summary.exit_code) == (Outcome.PART_FAILED, 1)
    assert {s.vx for s in trial.vehicle.setpoints()} == {0.0}
    assert trial.output.getvalue().count("not finite") == 1
    assert not trial.vehicle.armed


def test_a_second_signal_ends_at_once(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script(gates=None))

    def interrupt() -> None:
        trial.vehicle.flying.wait(20)
        os.kill(os.getpid(), signal.SIGINT)
        trial.vehicle.landing.wait(20)
        os.kill(os.getpid(), signal.SIGINT)

    thread = threading.Thread(target=interrupt)
    thread.start()
    summary = trial.fly()
    thread.join()
    assert (summary.outcome, summary.exit_code) == (Outcome.INTERRUPTED, 130)
    assert trial.vehicle.armed
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
    assert sum(1 for _ in read_tlog(trial.plan.log)) > 100


def test_any_camera_will_do(tmp_path: Path) -> None:
    video = tmp_path / "flight.avi"
    write_video(video)
    script = Script(gates=None, has_camera=False)
    trial = Trial(tmp_path, script, camera=str(video), duration_s=2.0)
    summary = trial.fly()
    assert (summary.outcome, summary.exit_code) == (Outcome.COMPLETED, 0)
    assert trial.pilot.images[0].rgb[5, 5, 0] > 240
    stamps_ms = [setpoint.time_boot_ms for setpoint in trial.vehicle.setpoints()]
    assert stamps_ms == sorted(stamps_ms)
    assert stamps_ms[-1] <= trial.vehicle.time_us / 1000 + 1000


def test_a_camera_may_start_later_than_the_companion(tmp_path: Path) -> None:
    video = tmp_path / "flight.avi"
    script = Script(gates=None, has_camera=False)
    trial = Trial(tmp_path, script, camera=str(video), duration_s=1.0)
    starting = threading.Timer(0.7, write_video, args=(video,))
    starting.start()
    summary = trial.fly()
    starting.join()
    assert summary.outcome is Outcome.COMPLETED


def test_a_camera_that_never_starts_is_told(tmp_path: Path) -> None:
    script = Script(gates=None, has_camera=False)
    with pytest.raises(LinkError, match=r"camera .*no-such\.avi cannot be reached"):
        Trial(tmp_path, script, camera=str(tmp_path / "no-such.avi"), timeout_s=0.7).fly()


def write_video(path: Path) -> None:
    partial = path.with_suffix(".part.avi")
    writer = cv2.VideoWriter(str(partial), cv2.VideoWriter.fourcc(*"MJPG"), 50.0, (64, 64))
    for number in range(500):
        image = np.full((64, 64, 3), (0, 0, 255), np.uint8)
        image[number % 64] = 255
        writer.write(image)
    writer.release()
    partial.replace(path)


def test_no_vehicle_is_told(tmp_path: Path) -> None:
    endpoint = parse_endpoint(f"udpin:127.0.0.1:{free_port()}")
    plan = FlightPlan(endpoint=endpoint, log=tmp_path / "flight.tlog", timeout_s=0.2)
    with pytest.raises(LinkError, match=r"no vehicle heard on udpin:.* for 0\.2 s"):
        fly(plan, guarded, Console(verbosity=-1))
    assert not plan.log.exists()


def test_a_vehicle_without_camera_is_told(tmp_path: Path) -> None:
    with pytest.raises(LinkError, match="--camera"):
        Trial(tmp_path, Script(has_camera=False), timeout_s=1.0).fly()


def test_an_autopilot_that_is_no_px4_is_told(tmp_path: Path) -> None:
    with pytest.raises(LinkError, match=r"looked past: system 1 at .*, an ArduPilot"):
        Trial(tmp_path, Script(autopilot=3), timeout_s=1.0).fly()


def test_a_signal_lands_first(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script(gates=None))

    def interrupt() -> None:
        trial.vehicle.flying.wait(20)
        os.kill(os.getpid(), signal.SIGTERM)

    thread = threading.Thread(target=interrupt)
    thread.start()
    summary = trial.fly()
    thread.join()
    assert (summary.outcome, summary.exit_code) == (Outcome.INTERRUPTED, 130)
    assert not trial.vehicle.armed
