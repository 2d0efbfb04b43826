"""PX4's own logs: the same columns as pyulog's, and the flight that they hold."""

from pathlib import Path

import numpy as np
import pytest
import pyulog

from flightstack.logs import Log, LogFileError, read
from flightstack.logs.checks import Level, run_checks
from flightstack.logs.flight.flight import Flight
from flightstack.logs.flight.parameters import read_parameters
from tests.unit.flightstack.logs.made_onboard import (
    BOOT_UTC_US,
    UlogTopic,
    px4_log,
    px4_topics,
    sway,
    ulog,
)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "vehicle.ulg"
    path.write_bytes(px4_log())
    return path


def test_columns_are_those_of_pyulog(path: Path) -> None:
    log = read(path)
    for dataset in pyulog.ULog(str(path)).data_list:
        name = dataset.name + (f"_{dataset.multi_id}" if dataset.multi_id else "")
        table = log[name]
        assert len(table) == len(dataset.data["timestamp"])
        for field, values in dataset.data.items():
            base, _, index = field.rstrip("]").partition("[")
            if table.type.field(base).is_text:
                continue
            column = table[base][:, int(index)] if index else table[base]
            assert np.array_equal(column, values), field


def test_what_pyulog_writes_is_read_alike(path: Path, tmp_path: Path) -> None:
    again = tmp_path / "again.ulg"
    pyulog.ULog(str(path)).write_ulog(str(again))
    one, other = read(path), read(again)
    assert one.counts == other.counts
    assert one["ATTITUDE"].data.tobytes() == other["ATTITUDE"].data.tobytes()


def test_the_flight_is_what_was_flown(path: Path) -> None:
    flight = Flight(read(path))
    assert flight.vehicle is not None
    assert (flight.vehicle.system, flight.vehicle.kind) == (7, "px4 quadrotor")
    assert [span.label for span in flight.modes] == ["AUTO.LOITER", "OFFBOARD", "AUTO.LOITER"]
    assert [span.duration_s for span in flight.armed] == [34.0]
    assert [span.duration_s for span in flight.flying] == [30.0]
    assert flight.ending == "landed and disarmed"
    assert flight.start_us == BOOT_UTC_US + 500_000


def test_messages_say_what_topics_hold(path: Path) -> None:
    log = read(path)
    attitude, position = log["ATTITUDE"], log["LOCAL_POSITION_NED"]
    flown = [sway(ms * 1e-3) for ms in attitude["time_boot_ms"].tolist()]
    angles = [(m.roll, m.pitch, m.yaw) for m in flown]
    told = np.stack([attitude[name] for name in ("roll", "pitch", "yaw")], axis=1)
    assert told == pytest.approx(np.array(angles), abs=1e-6)
    assert position["z"] == pytest.approx([m.position[2] for m in flown], abs=1e-6)
    assert attitude.units["roll"] == "rad"
    gps = log["GPS_RAW_INT"]
    assert gps["lat"].tolist() == [471_000_000] * len(gps)
    assert gps["satellites_visible"][0] == 12
    assert log["SERVO_OUTPUT_RAW"]["servo1_raw"][0] == 1500
    assert log["SYS_STATUS"]["battery_remaining"][0] == 90


def test_texts_are_whole_however_long(path: Path) -> None:
    texts = Flight(read(path)).texts
    assert [text.text for text in texts] == ["[commander] Armed by external command", "w" * 70]
    assert [text.level for text in texts] == ["info", "warning"]


def test_parameters_keep_their_types(path: Path) -> None:
    values = read_parameters(Flight(read(path))).values
    assert values == {"MAV_TYPE": 2, "MPC_XY_VEL_MAX": 12.0}


def test_texts_of_topics_and_instances(path: Path) -> None:
    log = read(path)
    assert log["debug_key_value"]["key"].tolist() == ["depth"]
    assert log["sensor_accel"]["x"][0] == 1.0
    assert log["sensor_accel_1"]["x"][0] == 2.0


def found(log: Log, name: str) -> tuple[Level, str]:
    finding = next(each for each in run_checks(Flight(log)) if each.name == name)
    return finding.level, finding.reason


def test_checks_judge_what_the_log_can_tell(path: Path) -> None:
    log = read(path)
    assert found(log, "setpoint_rate")[0] is Level.SKIPPED
    assert found(log, "link_loss")[0] is Level.SKIPPED
    assert found(log, "tracking_error")[0] is Level.OK
    assert found(log, "dropouts") == (Level.OK, "none")
    assert found(log, "motor_saturation")[0] is Level.WARNING


def test_dropouts_are_found(tmp_path: Path) -> None:
    path = tmp_path / "gaps.ulg"
    path.write_bytes(px4_log(dropouts=[120, 1500]))
    level, reason = found(read(path), "dropouts")
    assert level is Level.ERROR
    assert reason == "2 dropouts, 1.62 s in all, longest 1.50 s at 0.0 s"


def test_a_cut_log_is_read_as_far_as_it_goes(path: Path) -> None:
    raw = path.read_bytes()
    path.write_bytes(raw[: len(raw) // 2])
    whole = len(px4_topics()[0].rows)
    assert whole // 4 < len(read(path)["vehicle_attitude"]) < whole


def test_older_field_names_are_understood(tmp_path: Path) -> None:
    path = tmp_path / "old.ulg"
    gps = UlogTopic("vehicle_gps_position", "uint64_t timestamp;uint32_t lat;uint32_t lon;",
                    [(1_000_000, 471_000_000, 82_000_000)])  # fmt: skip
    status = UlogTopic("vehicle_status",
                       "uint64_t timestamp;uint8_t arming_state;uint8_t nav_state;"
                       "uint8_t vehicle_type;", [(1_000_000, 2, 3, 2)])  # fmt: skip
    path.write_bytes(ulog([gps, status]))
    log = read(path)
    assert log["GPS_RAW_INT"]["lat"].tolist() == [471_000_000]
    vehicle = Flight(log).vehicle
    assert vehicle is not None
    assert vehicle.kind == "px4 fixed wing"


@pytest.mark.parametrize("rest", [b"", bytes(100), b"\xff" * 300])
def test_a_log_without_data_is_refused_in_one_line(tmp_path: Path, rest: bytes) -> None:
    path = tmp_path / "empty.ulg"
    path.write_bytes(b"ULog\x01\x12\x35\x01" + rest)
    with pytest.raises(LogFileError, match="PX4 ULog"):
        read(path)
