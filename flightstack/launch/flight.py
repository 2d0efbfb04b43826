"""Fly one course: start the vehicle and the companion as two processes, wait, clean up."""

import tempfile
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType

from flightstack.extensions import PICKLED
from flightstack.launch.brought import Brought, names_of
from flightstack.launch.cold import ColdStarter
from flightstack.launch.order import Order, Starter
from flightstack.launch.px4 import held_ports
from flightstack.launch.request import GIVES_UP, FlightRequest
from flightstack.launch.result import FlightResult, read_result

COLD = ColdStarter()
FINE_DAY: Mapping[str, object] = MappingProxyType({})


def fly(  # noqa: PLR0913  the options of `flightstack fly`, all by name
    *,
    laps: int = 1,
    track_seed: int = 0,
    noise: tuple[float, float] = (1.0, 2.0),
    seed: int = 0,
    conditions: Mapping[str, object] = FINE_DAY,
    model: str | None = None,
    strategy: Brought | None = None,
    perception: Brought | None = None,
    policy: Brought | None = None,
    pilot: Brought | None = None,
    speed_factor: float = 1.0,
    fast: bool = False,
    px4: Path | None = None,
    log: Path | None = None,
    record_frames: bool = False,
) -> FlightResult:
    """Fly as `flightstack fly` does with the options of these names, and say nothing on the way.

    `noise` is that of the gates' radius and height, m; `seed` is of light, sensors and sampling;
    `conditions` are those of docs/conditions.md, as {"camera.latency_s": 0.1}. With `px4`, the
    build folder or the binary of a real PX4, that one flies.

    `strategy`, `perception`, `policy` and `pilot` may be yours (docs/bring-your-own.md): a factory,
    or its name, "my_package:make_policy". One that Python can import travels to the companion as
    its name; any other, such as one of a notebook, as a file that cloudpickle writes and the
    companion's own process reads. Nothing of it ever goes over the wire.

    The companion's log is `log`, or one in the folder `logs` of the working directory, and with
    `record_frames` a folder beside it holds what the camera saw. A flight that began gives
    a result, whatever its outcome. Raises UsageError, ModelError or LinkError, in one line, where
    none began, or one was cut off. No process is left running, after Ctrl-C neither.
    """
    record = (
        *(() if log is None else (f"--log={log}",)),
        *(("--record-frames",) if record_frames else ()),
    )
    brought = {"strategy": strategy, "perception": perception, "policy": policy, "pilot": pilot}
    with tempfile.TemporaryDirectory(prefix="brought-") as folder:
        parts = names_of(brought, Path(folder))
        request = FlightRequest(
            laps=laps,
            track_seed=track_seed,
            noise=",".join(map(str, noise)),
            model=model,
            speed_factor=0.0 if fast else speed_factor,
            px4=px4,
            vehicle_options=("-q", *vehicle_options(seed, conditions)),
            companion_options=(
                *(*GIVES_UP, "-q", "--json", f"--seed={seed}"),
                *(f"--{option}={name}" for option, name in parts.items()),
                *record,
            ),
        )
        return _named(fly_request(request), brought, parts)


def _named(
    result: FlightResult, brought: Mapping[str, Brought | None], parts: Mapping[str, str]
) -> FlightResult:
    """Say what flew by the name of its code, rather than of the file in which it travelled."""
    told = {
        name: getattr(brought[option], "__qualname__", option)
        for option, name in parts.items()
        if name != brought[option] and name.endswith(PICKLED)
    }
    model, strategy = (told.get(name, name) for name in (result.model, result.strategy))
    return replace(result, model=model, strategy=strategy)


def vehicle_options(seed: int, conditions: Mapping[str, object]) -> tuple[str, ...]:
    """Return what `python -m sitl` is told of the day."""
    lists = {k: list(v) if isinstance(v, tuple) else v for k, v in conditions.items()}  # as TOML
    return (f"--seed={seed}", *(f"--condition={name}={value!r}" for name, value in lists.items()))


def fly_request(request: FlightRequest, starter: Starter = COLD) -> FlightResult:
    """Fly on the ports of a free instance; raises as `fly` does."""
    with (
        held_ports(request) as ports,
        tempfile.TemporaryDirectory(prefix="flight-") as folder,
    ):
        order = Order(request=request, ports=ports, folder=Path(folder))
        return read_result(starter.fly(order), request)
