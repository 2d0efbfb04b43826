"""The report is one page that needs nothing else and shows what the log holds."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from pymavlink.dialects.v20 import all as mavlink

from flightstack.logs import read, read_bytes
from flightstack.logs.checks import run_checks
from flightstack.logs.flight.course import gate_outline
from flightstack.logs.flight.flight import Flight
from flightstack.logs.report.page import make_page
from flightstack.logs.report.plotting import thinned
from flightstack.logs.report.time_figure import time_figure
from tests.paths import GOLDEN
from tests.unit.flightstack.logs.made_flights import make_flight
from tests.unit.flightstack.logs.made_logs import START_US, record, tlog

pytest.importorskip("plotly")


def page_of(flight: Flight) -> str:
    return make_page(flight, run_checks(flight))


def own_part(page: str) -> str:
    """Return the page without plotly.js."""
    start = page.index("/**\n* plotly.js")
    return page[:start] + page[page.index("</script>", start) :]


def test_the_page_refers_to_nothing_outside() -> None:
    own = own_part(page_of(Flight(read(GOLDEN))))
    assert not re.findall(r"""(?:src|href)\s*=\s*["'](?!data:)""", own)
    assert "http" not in own.replace("http-equiv", "")
    assert "showSendToCloud: false" in own


def test_the_page_shows_what_the_issue_asks_for() -> None:
    flight = Flight(read_bytes(make_flight(20.0)))
    page = own_part(page_of(flight))
    for words in (
        "Why did it miss?",
        "Course",
        "Over time",
        "Health checks",
        "what it means",
        "Missed gate 6: passed outside",
        "1 error",
        "Passed 5 gates",
    ):
        assert words in page, words
    titles = {
        axis["title"]["text"]
        for name, axis in time_figure(flight)["layout"].items()
        if name.startswith("yaxis")
    }
    assert titles >= {
        "modes",
        "vx, m/s",
        "vy, m/s",
        "vz, m/s",
        "yaw rate, rad/s",
        "std, m/s",
        "member",
        "latency, ms",
    }


def test_text_in_a_log_cannot_become_script() -> None:
    evil = b"</script><script>alert(1)</script><b>"[:50]
    sender = mavlink.MAVLink(None, 1, 1)
    text = mavlink.MAVLink_statustext_message(6, evil).pack(sender)
    page = own_part(page_of(Flight(read_bytes(make_flight(3.0) + record(START_US, text)))))
    assert "<script>alert" not in page
    figures = re.search(r'id="figures">(.*?)</script>', page, re.DOTALL)
    assert figures is not None
    assert evil.decode().rstrip() in json.dumps(json.loads(figures[1]))


@pytest.mark.parametrize(
    "data",
    [
        tlog([mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3)] * 3),
        tlog([mavlink.MAVLink_heartbeat_message(2, 3, 81, 4, 4, 3)] * 3),
        make_flight(20.0)[:40_000],
    ],
    ids=["no autopilot", "no position", "cut"],
)
def test_any_log_has_a_report(data: bytes) -> None:
    assert "Health checks" in own_part(page_of(Flight(read_bytes(data))))


def test_recorded_images_stand_in_the_strip(tmp_path: Path) -> None:
    flight = Flight(read_bytes(make_flight(20.0)))
    png = b"\x89PNG not really"
    for stamp_us in flight.decisions.stamp_us.tolist():
        (tmp_path / f"{stamp_us:012d}.png").write_bytes(png)
    page = own_part(make_page(flight, [], tmp_path))
    assert page.count('src="data:image/png;base64,') == 8


def test_gates_are_drawn_across_their_axis() -> None:
    gate = Flight(read_bytes(make_flight(3.0))).gates[2]  # passed heading east
    outline = gate_outline(gate)
    assert np.ptp(outline[:, 1]) == pytest.approx(0, abs=1e-9)
    assert np.ptp(outline[:, 0]) == pytest.approx(1.2)
    assert np.ptp(outline[:, 2]) == pytest.approx(1.2)


def test_thinning_keeps_every_peak() -> None:
    x = np.arange(100_000.0)
    y = np.sin(x / 500)
    y[54_321] = 9.0
    thin_x, thin_y = thinned(x, y, 2000)
    assert len(thin_x) <= 2000
    assert 9.0 in thin_y
    assert np.all(np.diff(thin_x) > 0)
