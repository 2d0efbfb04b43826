"""What a starter is ordered to fly, and how the two processes of a flight ended."""

from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from flightstack.launch.ports import Ports
from flightstack.launch.request import FlightRequest

VEHICLE, COMPANION = "sitl", "companion"  # also the processes' names, as `ps` shows them
BANNER = "pybullet build time:"


@dataclass(frozen=True, slots=True, kw_only=True)
class Order:
    """One flight to be flown."""

    request: FlightRequest
    ports: Ports
    folder: Path  # which takes what both print, as NAME.out and NAME.err
    limit_s: float | None = None  # wall time: what takes longer hangs


@dataclass(frozen=True, slots=True, kw_only=True)
class Ended:
    """How both ended: the exit code, minus the signal, or None where the starter ended it."""

    vehicle: int | None
    companion: int | None
    folder: Path
    px4: str | None = None  # how a real PX4 ended, where it did so by itself

    def output(self, name: str) -> str:
        """Read what a process wrote to standard output."""
        return _read(self.folder / f"{name}.out")

    def errors(self, name: str) -> str:
        """Read what a process wrote to standard error."""
        return _read(self.folder / f"{name}.err")


class Starter(Protocol):
    """Starts the two processes of one flight after another; for one thread."""

    def prepare(self) -> None:
        """Do what is no part of the next flight."""

    def fly(self, order: Order) -> Ended:
        """Fly to the end, and leave no process behind."""

    def close(self) -> None:
        """End what is kept for the next flight."""


def last_line(text: str) -> str:
    """Pick the last line that is no library's banner, or say that there is none."""
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith(BANNER)]
    return lines[-1] if lines else "it said nothing"


def _read(path: Path) -> str:
    return path.read_text(errors="replace") if path.exists() else ""
