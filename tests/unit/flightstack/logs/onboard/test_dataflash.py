"""ArduPilot's own logs: the same values as DFReader's, and the flight that they hold."""

from pathlib import Path

import numpy as np
import pytest
from pymavlink import DFReader

from flightstack.logs import LogFileError, read
from flightstack.logs.flight.flight import Flight
from flightstack.logs.flight.parameters import read_parameters
from tests.unit.flightstack.logs.made_onboard import (
    ATT,
    BAT,
    BOOT_UTC_US,
    ERR,
    MSG,
    PARM,
    STAT,
    ardupilot_log,
    flash_head,
    sway,
)

DESCRIPTIONS = ("FMT", "FMTU", "UNIT")


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "vehicle.bin"
    path.write_bytes(ardupilot_log())
    return path


def test_every_value_is_that_of_dfreader(path: Path) -> None:
    log = read(path)
    reader = DFReader.DFReader_binary(str(path))
    rows = {name: iter(zip(log[name].time_s.tolist(), log[name].rows(), strict=True))
            for name in log.counts}  # fmt: skip
    seen = 0
    while (message := reader.recv_msg()) is not None:
        if message.get_type() in DESCRIPTIONS:
            continue
        core = message.C if message.get_type() == "XKF1" else 0
        time_s, values = next(rows[f"XKF1_{core}" if core else message.get_type()])
        assert list(values) == [getattr(message, name) for name in message.get_fieldnames()]
        assert time_s == pytest.approx(message._timestamp, abs=2e-3)  # GPS tells milliseconds
        seen += 1
    reader.close()
    assert seen == len(log)


def test_the_flight_is_what_was_flown(path: Path) -> None:
    flight = Flight(read(path))
    assert flight.vehicle is not None
    assert (flight.vehicle.system, flight.vehicle.kind) == (7, "ardupilotmega hexarotor")
    assert [span.label for span in flight.modes] == ["STABILIZE", "GUIDED"]
    assert [span.duration_s for span in flight.armed] == [34.0]
    assert [span.duration_s for span in flight.flying] == [30.0]
    assert flight.ending == "landed and disarmed"
    assert flight.texts[0].text == "ArduCopter V4.5.7 (2a3dc4b7)"
    assert flight.start_us == pytest.approx(BOOT_UTC_US + 1000, abs=2000)


def test_messages_say_what_records_hold(path: Path) -> None:
    log = read(path)
    attitude = log["ATTITUDE"]
    flown = [sway(ms * 1e-3) for ms in attitude["time_boot_ms"].tolist()]
    told = np.stack([attitude[name] for name in ("roll", "pitch", "yaw")], axis=1)
    angles = np.array([(m.roll, m.pitch, m.yaw) for m in flown])
    assert told == pytest.approx(angles, abs=1e-4)  # hundredths of a degree
    assert log["LOCAL_POSITION_NED"]["x"] == pytest.approx([m.position[0] for m in flown], abs=1e-6)
    assert log["GPS_RAW_INT"]["lon"][0] == 82_000_000
    assert log["SERVO_OUTPUT_RAW"]["servo4_raw"].max() == 2000
    assert log["SYS_STATUS"]["voltage_battery"][0] == 16_000


def test_units_are_those_of_fmtu(path: Path) -> None:
    log = read(path)
    assert log["ATT"].units["Roll"] == "deg"
    assert log["XKF1"].units["VN"] == "m/s"


def test_parameters_and_their_changes(path: Path) -> None:
    parameters = read_parameters(Flight(read(path)))
    assert parameters.values["WPNAV_SPEED"] == 700.0
    assert [(c.name, c.before, c.after) for c in parameters.changes] == [
        ("WPNAV_SPEED", 500.0, 700.0)
    ]


def test_a_failsafe_is_told(tmp_path: Path) -> None:
    path = tmp_path / "failsafe.bin"
    more = [(10_000_000, ERR.record(10_000_000, 6, 1)), (12_000_000, ERR.record(12_000_000, 6, 0))]
    path.write_bytes(ardupilot_log(more))
    flight = Flight(read(path))
    assert [(f.label, f.duration_s) for f in flight.failsafes] == [("critical", 2.0)]
    assert "Failsafe: battery (code 1)" in [text.text for text in flight.texts]


@pytest.mark.parametrize(
    ("firmware", "extra", "kind"),
    [
        ("ArduPlane", [], "fixed wing"),
        ("ArduPlane", [(2000, PARM.record(2000, b"Q_ENABLE", 1.0))], "vtol"),
        ("Rover", [], "surface boat"),
        ("ArduRover", [(2000, PARM.record(2000, b"FRAME_CLASS", 1.0))], "ground rover"),
        ("ArduSub", [], "submarine"),
    ],
)
def test_the_firmware_tells_the_vehicle(
    tmp_path: Path, firmware: str, extra: list[tuple[int, bytes]], kind: str
) -> None:
    path = tmp_path / "vehicle.bin"
    path.write_bytes(ardupilot_log(extra, firmware))
    vehicle = Flight(read(path)).vehicle
    assert vehicle is not None
    assert kind in vehicle.kind


def test_a_plane_flies_when_stat_says_so(tmp_path: Path) -> None:
    path = tmp_path / "plane.bin"
    flying = [(t, STAT.record(t, int(5_000_000 <= t < 25_000_000), 1.0, 1))
              for t in range(1_000_000, 30_000_000, 1_000_000)]  # fmt: skip
    text = (1000, MSG.record(1000, b"ArduPlane V4.5.7"))
    records = sorted([text, *flying], key=lambda each: each[0])
    path.write_bytes(flash_head() + b"".join(raw for _, raw in records))
    made = read(path)["EXTENDED_SYS_STATE"]
    aloft = made.time_us[made["landed_state"] == 2]
    assert (aloft.min(), aloft.max()) == (5_000_000, 24_000_000)


def test_damage_is_located_and_stepped_over(path: Path) -> None:
    raw = path.read_bytes()
    place = raw.index(BAT.record(5_000_000, 0, 16.0, 5.0, 90))
    path.write_bytes(raw[:place] + b"\x00" * 37 + raw[place:])
    log = read(path)
    regions = [(region.offset, region.length) for region in log.damage.regions]
    assert regions == [(place, 37)]
    assert len(log["BAT"]) == 75
    assert not read_is_damaged(path, raw + b"\xff" * 100)
    assert read_is_damaged(path, raw[:-5])


def read_is_damaged(path: Path, raw: bytes) -> bool:
    path.write_bytes(raw)
    return bool(read(path).damage.regions)


def test_a_log_without_records_is_refused_in_one_line(tmp_path: Path) -> None:
    path = tmp_path / "empty.bin"
    path.write_bytes(flash_head())
    with pytest.raises(LogFileError, match=r"ArduPilot \.bin without any record"):
        read(path)


def test_a_log_cut_anywhere_is_read_or_refused(path: Path) -> None:
    raw = path.read_bytes()
    for size in [2, 3, 50, 89, 1000, len(flash_head()) + 7, len(raw) // 3]:
        path.write_bytes(raw[:size])
        try:
            assert len(read(path)) > 0
        except LogFileError as error:
            assert "\n" not in str(error)  # noqa: PT017  # either is right
    assert ATT.name in read(path).counts
