"""No log, however damaged or strange, breaks what is said about it."""

import json

import numpy as np
import pytest

from flightstack.logs import Log, read_bytes
from flightstack.logs.checks import run_checks
from flightstack.logs.export.csv import rows
from flightstack.logs.facts.messages import message_facts
from flightstack.logs.facts.summary import summarise
from flightstack.logs.flight.flight import Flight
from flightstack.logs.flight.parameters import read_parameters
from flightstack.logs.report.course_figure import course_figure, has_course
from flightstack.logs.report.time_figure import time_figure
from flightstack.logs.text.lines import LineOptions, lines
from flightstack.logs.text.summary_text import one_line, page
from tests.paths import GOLDEN
from tests.unit.flightstack.logs.made_flights import make_flight
from tests.unit.flightstack.logs.made_logs import START_US, random_packets, record

SOURCES = {
    "made": make_flight(4.0),
    "golden": GOLDEN.read_bytes(),
    "random": b"".join(record(START_US + i, raw) for i, raw in enumerate(random_packets(800, 5))),
}


def say_everything(log: Log) -> None:
    flight = Flight(log)
    findings = run_checks(flight)
    assert not [f for f in findings if "the check itself failed" in f.reason]
    facts = summarise(flight, findings)
    json.dumps(facts, allow_nan=False)
    assert page(facts)
    assert one_line(facts)
    json.dumps(time_figure(flight))
    if has_course(flight):
        json.dumps(course_figure(flight))
    read_parameters(flight)
    assert sum(each["count"] for each in message_facts(log)) == len(log)
    for kind in ("standard", "json"):
        dumped = b"".join(lines(log, LineOptions(format=kind)))
        assert dumped.count(b"\n") >= sum(log.counts.values())
    for name in log.counts:
        assert rows(log[name]).count(b"\n") >= len(log[name])


@pytest.mark.parametrize("source", SOURCES)
def test_damaged_logs_break_nothing(source: str) -> None:
    rng = np.random.default_rng(3)
    clean = np.frombuffer(SOURCES[source], dtype=np.uint8)
    whole, recovered = read_bytes(SOURCES[source]), 0
    with np.errstate(all="ignore"):
        for _ in range(12):
            start, stop = np.sort(rng.integers(0, len(clean), size=2)).tolist()
            data = clean[start:stop].copy()
            hits = int(rng.integers(0, 300)) if len(data) else 0
            data[rng.integers(0, max(len(data), 1), size=hits)] = rng.integers(0, 256, size=hits)
            log = read_bytes(data)
            for name, count in log.counts.items():
                assert count <= whole.counts.get(name, 0)  # nothing that was not there
            assert sum(region.length for region in log.damage.regions) <= len(data)
            say_everything(log)
            recovered += len(log)
    assert recovered > 0


def test_an_empty_log_breaks_nothing() -> None:
    log = read_bytes(b"")
    assert len(log) == 0
    say_everything(log)
