"""Fly one trial to a row: again where it died, and never without saying so."""

import json
import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from flightstack.errors import FlightstackError, ModelError, UsageError
from flightstack.evaluation.experiment import Trial
from flightstack.evaluation.flights.command_lines import (
    LAP_LIMIT_S,
    LOG,
    companion_arguments,
    vehicle_arguments,
)
from flightstack.evaluation.flights.errors import FlightDiedError
from flightstack.evaluation.flights.fork_server import COMPANION, VEHICLE
from flightstack.evaluation.flights.ports import Ports
from flightstack.evaluation.flights.reading import Provenance, read_flight
from flightstack.evaluation.flights.trace import Trace
from flightstack.evaluation.flights.warm import WarmServer, last_line, words_of
from flightstack.evaluation.rows import TrialRow

ATTEMPTS = 3
START_S = 120.0  # wall time
SLOWEST = 1.0  # times real time: what is slower hangs
DIED = ("link_lost", "interrupted", "course_over")  # outcomes that say nothing about the pilot
RAN_FREE = "running free"  # the vehicle's words where lockstep was lost
EXITS = {2: UsageError, 4: ModelError}  # of a companion that cannot fly at all


@dataclass(frozen=True, slots=True, kw_only=True)
class Flown:
    """What came of a trial: a row, or only deaths."""

    trial: Trial
    row: TrialRow | None
    trace: Trace | None
    log: bytes | None  # where it was asked for
    wall_s: float
    deaths: tuple[str, ...]  # why each earlier attempt gave no row


class Launcher:
    """Flies trials one after another; for one thread."""

    def __init__(self) -> None:
        self._server: WarmServer | None = None

    def fly(self, trial: Trial, provenance: Provenance, *, keep_log: bool = False) -> Flown:
        """Fly up to ATTEMPTS times; raises UsageError or ModelError where no attempt can help."""
        began_s = time.monotonic()
        deaths: list[str] = []
        while len(deaths) < ATTEMPTS:
            with tempfile.TemporaryDirectory(prefix="flightstack-trial-") as name:
                try:
                    row, trace = self._attempt(trial, provenance, Path(name))
                except FlightDiedError as error:
                    deaths.append(str(error))
                    continue
                return Flown(
                    trial=trial,
                    row=replace(row, retries=len(deaths)),
                    trace=trace,
                    log=Path(name, LOG).read_bytes() if keep_log else None,
                    wall_s=time.monotonic() - began_s,
                    deaths=tuple(deaths),
                )
        wall_s = time.monotonic() - began_s
        return Flown(
            trial=trial, row=None, trace=None, log=None, wall_s=wall_s, deaths=tuple(deaths)
        )

    def close(self) -> None:
        """End the fork server."""
        if self._server is not None:
            self._server.close()
            self._server = None

    def _attempt(
        self, trial: Trial, provenance: Provenance, folder: Path
    ) -> tuple[TrialRow, Trace]:
        ports = Ports.find()
        order = {
            VEHICLE: vehicle_arguments(trial, ports),
            COMPANION: companion_arguments(trial, ports, folder),
            "folder": str(folder),
            "limit_s": START_S + LAP_LIMIT_S * trial.laps / SLOWEST,
        }
        exits = self._warm().fly(order)
        result = _result(exits, folder)
        try:
            return read_flight(trial, provenance, result, folder / LOG)
        except FlightstackError as error:
            raise FlightDiedError(f"its log cannot be read: {error}") from error

    def _warm(self) -> WarmServer:
        if self._server is not None and not self._server.is_alive:
            self.close()
        if self._server is None:
            self._server = WarmServer()
        return self._server


def _result(exits: dict[str, int | None], folder: Path) -> dict[str, Any]:
    """Read the companion's result; raises FlightDiedError where the flight was none."""
    code = exits[COMPANION]
    for name in (VEHICLE, COMPANION):
        ended, words = exits[name], words_of(folder, name)
        if name == VEHICLE and ended is not None and code is None:
            if ended == UsageError.exit_code:
                raise UsageError(last_line(words))
            raise FlightDiedError(f"the vehicle ended with {ended}: {last_line(words)}")
        if name == COMPANION and ended in EXITS:
            raise EXITS[ended](last_line(words))
    if code is None:
        raise FlightDiedError("it took too long")
    if RAN_FREE in words_of(folder, VEHICLE):
        raise FlightDiedError("lockstep was lost: the companion did not answer for long")
    line = last_line((folder / f"{COMPANION}.out").read_text())
    if not line.startswith("{"):
        raise FlightDiedError(f"the companion ended with {code}: {last_line(words)}")
    result: dict[str, Any] = json.loads(line)
    if result["outcome"] in DIED or result["gates_total"] is None:
        raise FlightDiedError(f"the flight ended by {result['outcome']}")
    return result
