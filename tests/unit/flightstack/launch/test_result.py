"""What two processes leave behind is a result, or an error that says what to do next."""

import json
from pathlib import Path

import pytest

from flightstack.errors import FlightstackError, LinkError, ModelError, UsageError
from flightstack.launch.errors import FlightCrashedError, FlightDiedError
from flightstack.launch.order import Ended, last_line
from flightstack.launch.request import FlightRequest
from flightstack.launch.result import FlightResult, read_result

TOLD = {
    "gates_passed": 7,
    "gates_total": 8,
    "outcome": "missed_gate",
    "duration_s": 25.5,
    "log": "logs/flight.tlog",
    "model": "strong/m0",
    "strategy": "de-mean",
    "real_time_factor": 9.5,
    "latency_ms": {"p50": 5.0, "p99": None},
    "frames": 510,
    "setpoints": 510,
}
REQUEST = FlightRequest(track_seed=7, noise="1,2.0")


def ended(folder: Path, *, vehicle: int | None, companion: int | None, said: str = "") -> Ended:
    for name in ("sitl", "companion"):
        (folder / f"{name}.err").write_text(said)
    return Ended(vehicle=vehicle, companion=companion, folder=folder)


def test_a_mission_that_failed_gives_its_result_in_the_keys_of_json(tmp_path: Path) -> None:
    (tmp_path / "companion.out").write_text(f"taking off\n{json.dumps(TOLD)}\n")
    result = read_result(ended(tmp_path, vehicle=0, companion=1), REQUEST)
    assert result.log == Path("logs/flight.tlog")
    assert json.loads(result.to_json()) == TOLD | {"track_seed": 7, "noise": [1.0, 2.0]}


def test_what_is_no_result_is_none() -> None:
    assert FlightResult.parse("completed: 8 of 8 gates\n", REQUEST) is None
    assert FlightResult.parse("", REQUEST) is None


@pytest.mark.parametrize(
    ("vehicle", "companion", "kind", "text"),
    [
        (2, None, UsageError, "sitl: no such day"),
        (None, 4, ModelError, "sitl: no such day"),
        (None, 1, FlightCrashedError, "the companion raised sitl: no such day"),
        (3, None, FlightDiedError, "the vehicle ended with 3: sitl: no such day"),
        (None, -9, FlightDiedError, "the companion ended with -9: sitl: no such day"),
        (None, None, LinkError, "it took too long"),
    ],
)
def test_a_flight_without_a_result_is_one_clear_line(
    vehicle: int | None,
    companion: int | None,
    kind: type[FlightstackError],
    text: str,
    tmp_path: Path,
) -> None:
    said = "warming up\nsitl: no such day\n"
    with pytest.raises(kind) as refusal:
        read_result(ended(tmp_path, vehicle=vehicle, companion=companion, said=said), REQUEST)
    assert str(refusal.value) == text


def test_a_librarys_banner_is_no_cause() -> None:
    banner = "pybullet build time: Nov 22 2026 10:00:00"
    assert last_line(f"out of memory\n{banner}\n\n") == "out of memory"
    assert last_line(f"{banner}\n") == "it said nothing"
    assert last_line("") == "it said nothing"
