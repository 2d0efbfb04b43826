"""Flights with one fault each, by real processes: the vehicle comes down, and somebody knows it."""

from pathlib import Path

import pytest

from scripts.bench.faults.flights import FlightKind, Flown, fly
from scripts.bench.faults.kinds import FAULTS, LINKS

pytestmark = pytest.mark.flight
BY_NAME = {fault.name: fault for fault in (*FAULTS, *LINKS)}


def flown(name: str, phase: str, folder: Path) -> Flown:
    return fly(BY_NAME[name], FlightKind(phase=phase, duration_s=6.0), folder)


@pytest.mark.parametrize(
    ("name", "phase", "outcome", "code"),
    [
        ("strategy calls sys.exit()", "flying", "part_failed", 1),
        ("companion killed, started again", "flying", "found_armed", 1),
        ("link out for 4 s", "flying", "link_lost", 3),
    ],
)
def test_a_fault_ends_on_the_ground(
    name: str, phase: str, outcome: str, code: int, tmp_path: Path
) -> None:
    ended = flown(name, phase, tmp_path)
    assert (ended.outcome, ended.code) == (outcome, code)
    assert not ended.armed
    assert not ended.died_badly
    assert ended.log_whole
