"""Lines for events; a live line only where there is a terminal."""

from dataclasses import replace
from io import StringIO
from pathlib import Path

import pytest

from flightstack.companion.console import ERASE_LINE, Console
from flightstack.companion.mission.records import MissionPhase
from flightstack.companion.reporter import Reporter
from tests.unit.flightstack.companion.made_flight import MadeFlight
from tests.unit.flightstack.mavlink.made_link import Wall


class Terminal(StringIO):
    def isatty(self) -> bool:
        return True


def told(verbosity: int) -> str:
    stream = StringIO()
    console = Console(verbosity=verbosity, stream=stream)
    console.event("event")
    console.detail("detail")
    console.warning("wrong")
    return stream.getvalue()


def test_verbosity_chooses_what_is_told() -> None:
    assert told(-1) == "warning: wrong\n"
    assert told(0) == "event\nwarning: wrong\n"
    assert told(1) == "event\ndetail\nwarning: wrong\n"


def test_a_file_gets_no_live_line() -> None:
    assert not Console(stream=StringIO()).wants_live


def test_the_live_line_is_renewed_five_times_a_second() -> None:
    wall = Wall()
    console = Console(stream=Terminal(), wall_s=wall)
    console.live("1.5 m/s")
    wall.now_s += 0.19
    assert not console.wants_live
    wall.now_s += 0.02
    assert console.wants_live


def test_events_stand_above_the_live_line() -> None:
    terminal = Terminal()
    console = Console(stream=terminal, wall_s=Wall())
    assert console.wants_live
    console.live("1.5 m/s")
    assert not console.wants_live
    console.event("gate 1")
    console.close()
    written = f"{ERASE_LINE}1.5 m/s{ERASE_LINE}gate 1\n1.5 m/s{ERASE_LINE}"
    assert terminal.getvalue() == written


def test_nothing_that_others_say_reaches_the_terminal_as_an_order() -> None:
    stream = StringIO()
    console = Console(verbosity=1, stream=stream)
    for tell in (console.event, console.detail, console.warning):
        tell("vehicle: \x1b]0;owned\x07\r\n\x9b2J\u202e")
    assert all(line.isprintable() for line in stream.getvalue().removesuffix("\n").split("\n"))
    assert stream.getvalue().count("\n") == 3


def test_the_live_line_goes_with_its_phase(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    flight, terminal = MadeFlight(tmp_path, monkeypatch), Terminal()
    reporter = Reporter(Console(stream=terminal, wall_s=flight.made.wall))
    status = flight.loop.status
    reporter.report(status, flight.session)
    assert " s" in terminal.getvalue().splitlines()[-1]  # the time flown, in a live line
    reporter.report(replace(status, phase=MissionPhase.LANDING), flight.session)
    assert terminal.getvalue().endswith(f"{ERASE_LINE}landing\n")
