"""What a flight came to, for people, programs and shells."""

import json
from pathlib import Path
from typing import Any

import pytest

from flightstack.companion.mission.records import Outcome
from flightstack.companion.summary import SENTENCES, FlightSummary


def summary(**changes: Any) -> FlightSummary:
    fields: dict[str, Any] = {
        "outcome": Outcome.COMPLETED,
        "gates_passed": 8,
        "gates_total": 8,
        "duration_s": 25.12345,
        "log": Path("logs/a.tlog"),
        "real_time_factor": 11.234,
        "latencies_s": tuple(k / 10000 for k in range(101)),
        "images": 600,
        "setpoints": 600,
    }
    return FlightSummary(**(fields | changes))


def test_json_is_one_line_with_every_field() -> None:
    line = summary().to_json(model="strong/m0", strategy="mi-mode")
    assert "\n" not in line
    assert json.loads(line) == {
        "gates_passed": 8,
        "gates_total": 8,
        "outcome": "completed",
        "duration_s": 25.123,
        "log": "logs/a.tlog",
        "model": "strong/m0",
        "strategy": "mi-mode",
        "real_time_factor": 11.23,
        "latency_ms": {"p50": 5.0, "p99": 9.9},
        "frames": 600,
        "setpoints": 600,
    }


def test_a_flight_without_images_has_no_latency() -> None:
    fields = json.loads(summary(latencies_s=()).to_json(model="m", strategy="s"))
    assert fields["latency_ms"] == {"p50": None, "p99": None}
    assert "frame to setpoint" not in summary(latencies_s=()).to_text()


@pytest.mark.parametrize("outcome", Outcome)
def test_every_outcome_has_words(outcome: Outcome) -> None:
    text = summary(outcome=outcome).to_text()
    assert text.startswith(SENTENCES[outcome])
    assert "8 of 8 gates" in text
    assert "logs/a.tlog" in text


@pytest.mark.parametrize(
    ("outcome", "code"),
    [
        (Outcome.COMPLETED, 0),
        (Outcome.MISSED_GATE, 1),
        (Outcome.COLLISION, 1),
        (Outcome.TIMEOUT, 1),
        (Outcome.TAKEN_OVER, 1),
        (Outcome.COURSE_OVER, 1),
        (Outcome.REFUSED, 1),
        (Outcome.LINK_LOST, 3),
        (Outcome.CAMERA_LOST, 3),
        (Outcome.INTERRUPTED, 130),
    ],
)
def test_exit_codes(outcome: Outcome, code: int) -> None:
    assert summary(outcome=outcome).exit_code == code
