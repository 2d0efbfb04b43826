"""The report for the owner of another vehicle shows what that told, and nothing that it did not."""

from typing import Any

import pytest
from pymavlink.dialects.v20 import all as mavlink

from flightstack.logs import read_bytes
from flightstack.logs.checks import run_checks
from flightstack.logs.flight.flight import Flight
from flightstack.logs.report.course_figure import course_figure
from flightstack.logs.report.page import make_page
from flightstack.logs.report.time_figure import time_figure
from tests.unit.flightstack.logs.kinds.made_vehicles import (
    ARDUPILOT,
    PLANE,
    PX4,
    QUAD,
    ROVER,
    SECOND,
    SUB,
    Entry,
    Sender,
    Vehicle,
    entries,
    tlog,
)
from tests.unit.flightstack.logs.made_logs import START_US

pytest.importorskip("plotly")


def gps(n: int) -> Any:
    return mavlink.MAVLink_gps_raw_int_message(n * 10**6, 3, 0, 0, 0, 90, 120, 0, 0, 9 + n % 3)


def told(autopilot: int) -> list[Entry]:
    """Return what an autopilot tells of its sensors, outputs and estimator."""

    def make(n: int) -> list[Any]:
        ratios = (0.1, 0.2, 0.3, 0.4)
        estimator = (
            mavlink.MAVLink_ekf_status_report_message(831, *ratios, 0.0)
            if autopilot == ARDUPILOT
            else mavlink.MAVLink_estimator_status_message(n * 10**6, 831, *ratios, 0, 0, 0, 0)
        )
        channels = [1500 + n] * 8 + [65535] * 10
        return [
            gps(n),
            mavlink.MAVLink_vfr_hud_message(14.0 + n, 15.0, 0, 40, 30.0, 0.0),
            mavlink.MAVLink_rc_channels_message(n * 1000, 8, *channels, 200),
            mavlink.MAVLink_servo_output_raw_message(n, 0, 1500, 1400 + n, 1300, 1200, 0, 0, 0, 0),
            mavlink.MAVLink_vibration_message(n * 10**6, 5.0, 6.0, 7.0, 0, 0, 0),
            estimator,
        ]

    sender = Sender()
    return [
        (START_US + n * SECOND + part, sender.pack(message))
        for n in range(60)
        for part, message in enumerate(make(n))
    ]


def titles(flight: Flight) -> set[str]:
    axes = time_figure(flight)["layout"].items()
    return {axis["title"]["text"] for name, axis in axes if name.startswith("yaxis")}


@pytest.mark.parametrize(
    ("kind", "autopilot"), [(QUAD, ARDUPILOT), (PLANE, ARDUPILOT), (QUAD, PX4)]
)
def test_the_page_shows_what_the_vehicle_told(kind: int, autopilot: int) -> None:
    vehicle = Vehicle(type=kind, autopilot=autopilot, speed_m_s=15.0)
    flight = Flight(read_bytes(tlog(entries(vehicle) + told(autopilot))))
    assert titles(flight) >= {
        "VFR, m/s",
        "GPS",
        "RC, us",
        "outputs, us",
        "vibration, m/s/s",
        "EKF, 1 is too much",
    }
    page = make_page(flight, run_checks(flight))
    for words in ("<h2>Path</h2>", "satellites at the least, 3D fix", "armed on the ground"):
        assert words in page, words
    for words in ("<h2>Course</h2>", "gates passed", "0.0 Hz", "setpoints</span>"):
        assert words not in page, words


def test_a_bare_log_gets_no_empty_rows() -> None:
    flight = Flight(read_bytes(tlog(entries(Vehicle()))))
    assert titles(flight) == {"modes", "height, m", "m/s", "tilt, deg", "battery, V"}


@pytest.mark.parametrize("extent", [30.0, 900.0, 24_000.0])
def test_the_path_has_a_scale_of_a_round_length(extent: float) -> None:
    flight = Flight(read_bytes(tlog(entries(Vehicle(speed_m_s=extent / 40)))))
    (bar,) = course_figure(flight)["layout"]["shapes"]
    length = bar["x1"] - bar["x0"]
    assert extent / 13 < length < extent / 4
    assert f"{length:e}"[0] in "125"


@pytest.mark.parametrize(("kind", "word"), [(ROVER, "driving"), (SUB, "submerged")])
def test_other_vehicles_get_their_own_words(kind: int, word: str) -> None:
    flight = Flight(
        read_bytes(
            tlog(entries(Vehicle(type=kind, speed_m_s=1.0, down=lambda t: min(t, 60 - t) / 4)))
        )
    )
    page = make_page(flight, run_checks(flight))
    assert f"<span>{word}</span>" in page
    assert "in the air" not in page


def test_a_restart_is_marked() -> None:
    again = [(time_us + 70 * SECOND, raw) for time_us, raw in entries(Vehicle())]
    flight = Flight(read_bytes(tlog(entries(Vehicle(boot_ms=400_000)) + again)))
    marks = [each["text"] for each in time_figure(flight)["layout"]["annotations"]]
    assert "started again" in marks
    assert "The autopilot started again 1 time." in make_page(flight, run_checks(flight))
