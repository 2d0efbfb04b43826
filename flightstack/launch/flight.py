"""Fly one course: start the vehicle and the companion as two processes, wait, clean up."""

import tempfile
from pathlib import Path

from flightstack.launch.cold import ColdStarter
from flightstack.launch.order import Order, Starter
from flightstack.launch.px4 import held_ports
from flightstack.launch.request import GIVES_UP, FlightRequest
from flightstack.launch.result import FlightResult, read_result

COLD = ColdStarter()


def fly(  # noqa: PLR0913  the options of scripts/fly, all by name
    *,
    laps: int = 1,
    track_seed: int = 0,
    noise_m: tuple[float, float] = (1.0, 2.0),
    model: str | None = None,
    strategy: str | None = None,
    speed_factor: float = 1.0,
    fast: bool = False,
    px4: Path | None = None,
) -> FlightResult:
    """Fly as `scripts/fly` does with the options of these names, and say nothing on the way.

    With `px4`, the build folder or the binary of a real PX4, that one flies.

    The companion's log is in the folder `logs` of the working directory. A flight that began gives
    a result, whatever its outcome. Raises UsageError, ModelError or LinkError, in one line, where
    none began, or one was cut off. No process is left running, after Ctrl-C neither.
    """
    request = FlightRequest(
        laps=laps,
        track_seed=track_seed,
        noise=",".join(map(str, noise_m)),
        model=model,
        strategy=strategy,
        speed_factor=0.0 if fast else speed_factor,
        px4=px4,
        vehicle_options=("-q",),
        companion_options=(*GIVES_UP, "-q", "--json"),
    )
    return fly_request(request)


def fly_request(request: FlightRequest, starter: Starter = COLD) -> FlightResult:
    """Fly on the ports of a free instance; raises as `fly` does."""
    with (
        held_ports(request) as ports,
        tempfile.TemporaryDirectory(prefix="flight-") as folder,
    ):
        order = Order(request=request, ports=ports, folder=Path(folder))
        return read_result(starter.fly(order), request)
