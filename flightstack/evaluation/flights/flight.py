"""Fly one trial to a row: again where it died, and never without saying so."""

import json
import tempfile
import time
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Self

from flightstack.errors import FlightstackError, ModelError, UsageError
from flightstack.evaluation.flights.command_lines import (
    LAP_LIMIT_S,
    LOG,
    companion_arguments,
    vehicle_arguments,
)
from flightstack.evaluation.flights.errors import FlightDiedError
from flightstack.evaluation.flights.fork_server import COMPANION, CRASHED, VEHICLE
from flightstack.evaluation.flights.ports import Ports
from flightstack.evaluation.flights.reading import Provenance, read_flight
from flightstack.evaluation.flights.trace import Trace
from flightstack.evaluation.flights.warm import WarmServer, last_line, words_of
from flightstack.evaluation.trials.experiment import Trial
from flightstack.evaluation.trials.rows import TrialRow

ATTEMPTS = 3
START_S = 120.0  # wall time
IMAGE_S = 0.05  # vehicle time between images
MIN_SPEED_FACTOR = 1.0  # times real time: what is slower hangs
DIED = ("link_lost", "interrupted", "course_over")  # outcomes that say nothing about the pilot
RAN_FREE = "running free"  # the vehicle's words where lockstep was lost
EXITS: dict[int | None, type[FlightstackError]] = {  # of who cannot fly at all
    UsageError.exit_code: UsageError,
    ModelError.exit_code: ModelError,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class CompletedFlight:
    """What one flight left behind."""

    row: TrialRow
    trace: Trace
    log: bytes | None  # where it was requested
    simulated_s: float  # vehicle time from the first image to the last
    flight_s: float  # wall time of the same


@dataclass(frozen=True, slots=True, kw_only=True)
class FlownTrial:
    """What came of a trial: a flight, or only deaths."""

    trial: Trial
    flight: CompletedFlight | None
    deaths: tuple[str, ...]  # why each earlier attempt gave no row
    wall_s: float  # of all attempts

    def after(self, deaths: int) -> Self:
        """Count so many more flights that died before, with the worker that flew them."""
        if self.flight is None:
            return self
        row = replace(self.flight.row, retries=self.flight.row.retries + deaths)
        return replace(self, flight=replace(self.flight, row=row))


class TrialFlyer:
    """Flies trials one after another; for one thread."""

    def __init__(self) -> None:
        self.scratch: Path | None = None  # for flights' folders; else where temporary files are
        self._server: WarmServer | None = None

    def fly(self, trial: Trial, provenance: Provenance, *, keep_log: bool = False) -> FlownTrial:
        """Fly up to ATTEMPTS times; raises UsageError or ModelError where no attempt can help."""
        self._warm()  # which is no part of the trial
        began_s = time.monotonic()
        deaths: list[str] = []
        flight = None
        while flight is None and len(deaths) < ATTEMPTS:
            try:
                flight = self._attempt(trial, provenance, keep_log=keep_log)
            except FlightDiedError as error:
                deaths.append(str(error))
        if flight is not None:
            flight = replace(flight, row=replace(flight.row, retries=len(deaths)))
        wall_s = time.monotonic() - began_s
        return FlownTrial(trial=trial, flight=flight, deaths=tuple(deaths), wall_s=wall_s)

    def close(self) -> None:
        """End the fork server."""
        if self._server is not None:
            self._server.close()
            self._server = None

    def _attempt(self, trial: Trial, provenance: Provenance, *, keep_log: bool) -> CompletedFlight:
        ports = Ports.find()
        with tempfile.TemporaryDirectory(prefix="trial-", dir=self.scratch) as name:
            folder = Path(name)
            order = {
                VEHICLE: vehicle_arguments(trial, ports),
                COMPANION: companion_arguments(trial, ports, folder),
                "folder": name,
                "limit_s": START_S + LAP_LIMIT_S * trial.laps / MIN_SPEED_FACTOR,
            }
            result = _result(trial, self._warm().fly(order), folder)
            try:
                row, trace = read_flight(trial, provenance, result, folder / LOG)
            except FlightstackError as error:
                raise FlightDiedError(f"its log cannot be read: {error}") from error
            simulated_s = result["frames"] * IMAGE_S
            return CompletedFlight(
                row=row,
                trace=trace,
                log=(folder / LOG).read_bytes() if keep_log else None,
                simulated_s=simulated_s,
                flight_s=simulated_s / result["real_time_factor"],
            )

    def _warm(self) -> WarmServer:
        if self._server is not None and not self._server.is_alive:
            self.close()
        if self._server is None:
            self._server = WarmServer()
        return self._server


def _result(trial: Trial, exits: dict[str, int | None], folder: Path) -> dict[str, Any]:
    """Read the companion's result; raises FlightDiedError where the flight was none.

    Raises UsageError or ModelError where a process refused its command line or its model, and
    UsageError where the companion raised what nobody expected, such as an error of a user's policy.
    """
    words = {name: words_of(folder, name) for name in (VEHICLE, COMPANION)}
    for name, code in exits.items():
        if code in EXITS:
            raise EXITS[code](last_line(words[name]))
    code = exits[COMPANION]
    if code == CRASHED:  # by an exception of its own, which the same flight raises again
        raise UsageError(
            f"{trial} cannot be flown: who flies it raised {last_line(words[COMPANION])}"
        )
    if code is None and exits[VEHICLE] is None:
        raise FlightDiedError("it took too long")
    if code is None:
        raise FlightDiedError(
            f"the vehicle ended with {exits[VEHICLE]}: {last_line(words[VEHICLE])}"
        )
    if RAN_FREE in words[VEHICLE]:
        raise FlightDiedError("lockstep was lost: the companion did not answer for long")
    line = last_line((folder / f"{COMPANION}.out").read_text())
    if not line.startswith("{"):
        raise FlightDiedError(f"the companion ended with {code}: {last_line(words[COMPANION])}")
    result: dict[str, Any] = json.loads(line)
    if result["outcome"] in DIED or result["gates_total"] is None:
        raise FlightDiedError(f"the flight ended by {result['outcome']}")
    return result
