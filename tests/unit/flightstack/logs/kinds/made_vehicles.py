"""Say what the logs tell of made vehicles, and make what other senders add to them."""

from collections.abc import Callable
from typing import Any

from pymavlink.dialects.v20 import all as mavlink

from flightstack.logs import read_bytes
from flightstack.logs.checks import run_checks
from flightstack.logs.facts.summary import summarise
from flightstack.logs.facts.values import Facts
from flightstack.logs.flight.flight import Flight
from scripts.make_logs import SECOND, START_US, Entry, MadeSender, tlog


def facts_of(rows: list[Entry], system: int | None = None) -> Facts:
    flight = Flight(read_bytes(tlog(rows)), system)
    return summarise(flight, run_checks(flight))


def level(facts: Facts, name: str) -> str:
    return next(str(each["level"]) for each in facts["checks"] if each["name"] == name)


def every(
    step_s: float, sender: MadeSender, make: Callable[[int], Any], end_s: float = 60
) -> list[Entry]:
    count = int(end_s / step_s)
    return [(START_US + round(n * step_s * SECOND) + 3, sender.pack(make(n))) for n in range(count)]


def beat(kind: int, autopilot: int, mode: int = 0) -> Any:
    return mavlink.MAVLink_heartbeat_message(kind, autopilot, 0, mode, 4, 3)
