"""What a check is, and how checks are registered and run."""

import importlib.util
import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any

from flightstack.logs.errors import LogFileError
from flightstack.logs.flight.flight import Flight


class Level(StrEnum):
    """How bad a finding is; the order is that of a page's worst-first list."""

    ERROR = "error"  # the flight was in danger, or cannot be judged
    WARNING = "warning"
    OK = "ok"
    SKIPPED = "skipped"  # the log does not hold what the check needs


Verdict = tuple[Level, str]  # the level, and the reason with the figures
Judge = Callable[[Flight], Verdict]


@dataclass(frozen=True, slots=True, kw_only=True)
class Check:
    """One question that is asked of every flight."""

    name: str
    title: str
    meaning: str  # why it matters and what to do, for a reader who does not know
    judge: Judge


@dataclass(frozen=True, slots=True, kw_only=True)
class Finding:
    """What one check found."""

    name: str
    title: str
    level: Level
    reason: str
    meaning: str

    def as_facts(self) -> dict[str, str]:
        """Return the finding as plain values."""
        return {"name": self.name, "level": self.level.value, "reason": self.reason}


def graded(value: float, *, warning: float, error: float = math.inf) -> Level:
    """Return how bad a value is that should be small: what is above the limits it passes."""
    if value > error:
        return Level.ERROR
    return Level.WARNING if value > warning else Level.OK


REGISTERED: dict[str, Check] = {}


def check(name: str, *, title: str, meaning: str) -> Callable[[Judge], Judge]:
    """Register a function as a check; it returns its level and the reason."""

    def register(judge: Judge) -> Judge:
        REGISTERED[name] = Check(name=name, title=title, meaning=meaning, judge=judge)
        return judge

    return register


def load_checks(path: Path) -> None:
    """Run a user's Python file, which registers its checks; LogFileError where it cannot."""
    spec = importlib.util.spec_from_file_location(f"user_checks_{path.stem}", path)
    if spec is None or spec.loader is None or not path.is_file():
        raise LogFileError(f"--checks {path}: no such Python file")
    module = importlib.util.module_from_spec(spec)
    try:
        spec.loader.exec_module(module)
    except (ImportError, SyntaxError, NameError, AttributeError, TypeError, ValueError) as error:
        raise LogFileError(f"--checks {path} cannot be loaded: {error}") from error


def _judged(each: Check, flight: Flight) -> Finding:
    try:
        level, reason = each.judge(flight)
    except (ArithmeticError, LookupError, TypeError, ValueError) as error:
        level, reason = Level.ERROR, f"the check itself failed: {type(error).__name__}: {error}"
    return Finding(
        name=each.name, title=each.title, level=level, reason=reason, meaning=each.meaning
    )


def run_checks(flight: Flight) -> list[Finding]:
    """Return what every registered check finds, worst first."""
    order: list[Any] = list(Level)
    findings = [_judged(each, flight) for each in REGISTERED.values()]
    return sorted(findings, key=lambda finding: order.index(finding.level))
