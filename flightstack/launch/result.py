"""What came of a flight: the record that `--json` prints, or the error that says why there is none.

The names of its fields are the keys of that JSON object.
"""

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Self

from flightstack.errors import FlightstackError, ModelError, UsageError
from flightstack.launch.errors import FlightCrashedError, FlightDiedError
from flightstack.launch.order import COMPANION, VEHICLE, Ended, last_line
from flightstack.launch.request import FlightRequest

UNCAUGHT = 1  # exit code of Python after an exception; with a result, of a mission that failed
REFUSALS: dict[int | None, type[FlightstackError]] = {  # of who cannot fly at all
    UsageError.exit_code: UsageError,
    ModelError.exit_code: ModelError,
}


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightResult:
    """One flight, as the companion tells of it."""

    gates_passed: int
    gates_total: int | None  # None where nobody judges
    outcome: str  # "completed", "missed_gate", "collision", "timeout", ...
    duration_s: float  # vehicle time from offboard to the end
    log: Path  # the companion's tlog, from the folder in which it flew
    model: str
    strategy: str
    real_time_factor: float
    latency_ms: dict[str, float | None]  # p50 and p99, from an image to its setpoint
    frames: int  # images decided on
    setpoints: int
    track_seed: int
    noise: tuple[float, ...]  # m, of the gates' radius and height

    @classmethod
    def parse(cls, output: str, request: FlightRequest) -> Self | None:
        """Read it off the last line that the companion printed; None where that says nothing."""
        line = output.rstrip().rpartition("\n")[2]
        if not line.startswith("{"):
            return None
        fields: dict[str, Any] = json.loads(line)
        known = {"track_seed": request.track_seed, "noise": noise_m(request)}
        return cls(**fields | {"log": Path(fields["log"])} | known)

    def to_json(self) -> str:
        """Write one JSON object on one line."""
        return json.dumps(asdict(self) | {"log": str(self.log)})


def noise_m(request: FlightRequest) -> tuple[float, ...]:
    """Return the noise of the gates' radius and height, m."""
    return tuple(float(figure) for figure in request.noise.split(","))


def read_result(ended: Ended, request: FlightRequest) -> FlightResult:
    """Return the result of a flight that was one, however it ended.

    Raises UsageError or ModelError where a process refused its command line or its model;
    FlightCrashedError where the companion raised what nobody expected; FlightDiedError where a
    process died, or never came up.
    """
    codes = {COMPANION: ended.companion, VEHICLE: ended.vehicle}
    for name, code in codes.items():
        if code in REFUSALS:
            raise REFUSALS[code](last_line(ended.errors(name)))
    if ended.companion is None:
        if ended.vehicle is None:
            raise FlightDiedError("it took too long")
        words = last_line(ended.errors(VEHICLE))
        raise FlightDiedError(f"the vehicle ended with {ended.vehicle}: {words}")
    result = FlightResult.parse(ended.output(COMPANION), request)
    if result is not None:
        return result
    if ended.px4 is not None:
        raise FlightDiedError(ended.px4)
    words = last_line(ended.errors(COMPANION))
    if ended.companion == UNCAUGHT:
        raise FlightCrashedError(f"the companion raised {words}")
    raise FlightDiedError(f"the companion ended with {ended.companion}: {words}")
