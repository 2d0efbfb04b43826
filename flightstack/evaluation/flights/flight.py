"""Fly one trial to a row: again where it died, and never without saying so."""

import contextlib
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Self

from flightstack.errors import FlightstackError, UsageError
from flightstack.evaluation.flights.reading import Provenance, read_flight
from flightstack.evaluation.flights.trace import Trace
from flightstack.evaluation.flights.trial_request import request_of
from flightstack.evaluation.trials.experiment import Trial
from flightstack.evaluation.trials.rows import TrialRow
from flightstack.launch.cold import ColdStarter
from flightstack.launch.errors import FlightCrashedError, FlightDiedError
from flightstack.launch.order import VEHICLE, Ended, Order, Starter
from flightstack.launch.ports import Ports
from flightstack.launch.px4 import held_ports
from flightstack.launch.request import LAP_LIMIT_S, FlightRequest
from flightstack.launch.result import FlightResult, read_result
from flightstack.launch.warm import WarmStarter

ATTEMPTS = 3
START_S = 120.0  # wall time
IMAGE_S = 0.05  # vehicle time between images
MIN_SPEED_FACTOR = 1.0  # times real time: what is slower hangs
DIED = (  # outcomes that say nothing about the pilot
    "link_lost",
    "interrupted",
    "course_over",
    "vehicle_restarted",
    "found_armed",
    "other_pilot",
    "companion_failed",
)
RAN_FREE = "running free"  # the vehicle's words where lockstep was lost
LOG = "companion.tlog"


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

    def __init__(self, starter: Starter | None = None, *, px4: Path | None = None) -> None:
        """Fly by a real PX4, where one is given, which is started anew for each flight."""
        self.scratch: Path | None = None  # for flights' folders; else where temporary files are
        self._px4 = px4
        self._starter = starter or (WarmStarter() if px4 is None else ColdStarter())

    def fly(self, trial: Trial, provenance: Provenance, *, keep_log: bool = False) -> FlownTrial:
        """Fly up to ATTEMPTS times; raises UsageError or ModelError where no attempt can help."""
        self._starter.prepare()
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
        """End what was kept to start flights."""
        self._starter.close()

    def _attempt(self, trial: Trial, provenance: Provenance, *, keep_log: bool) -> CompletedFlight:
        with tempfile.TemporaryDirectory(prefix="trial-", dir=self.scratch) as name:
            log = Path(name, LOG)
            request = replace(request_of(trial, log), px4=self._px4)
            limit_s = START_S + LAP_LIMIT_S * trial.laps / MIN_SPEED_FACTOR
            with _ports(request) as ports:
                order = Order(request=request, ports=ports, folder=Path(name), limit_s=limit_s)
                result = _result(trial, request, self._starter.fly(order))
            try:
                row, trace = read_flight(trial, provenance, result, log)
            except FlightstackError as error:
                raise FlightDiedError(f"its log cannot be read: {error}") from error
            simulated_s = result.frames * IMAGE_S
            return CompletedFlight(
                row=row,
                trace=trace,
                log=log.read_bytes() if keep_log else None,
                simulated_s=simulated_s,
                flight_s=simulated_s / result.real_time_factor,
            )


@contextlib.contextmanager
def _ports(request: FlightRequest) -> Iterator[Ports]:
    """Give free ports; those of a real PX4 are fixed by its instance, which is held."""
    if request.px4 is None:
        yield Ports.find()
        return
    with held_ports(request) as ports:
        yield ports


def _result(trial: Trial, request: FlightRequest, ended: Ended) -> FlightResult:
    """Read the companion's result; raises FlightDiedError where the flight tells nothing.

    Raises UsageError or ModelError where a process refused its command line or its model, and
    UsageError where the companion raised what nobody expected, such as an error of a user's policy.
    """
    try:
        result = read_result(ended, request)
    except FlightCrashedError as error:  # which the same flight would raise again
        raise UsageError(f"{trial} cannot be flown: {error}") from error
    if RAN_FREE in ended.errors(VEHICLE):
        raise FlightDiedError("lockstep was lost: the companion did not answer for long")
    if result.outcome in DIED or result.gates_total is None:
        raise FlightDiedError(f"the flight ended by {result.outcome}")
    return result
