"""A vehicle as MAVSDK sees it: a real process, found over its API link."""

import contextlib
import queue
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from mavsdk import ComponentType, Configuration, Mavsdk, System

from scripts.fly_course import API_PORT, free_instance
from tests.flight.processes import process

SPEED_FACTOR = 5.0  # MAVSDK streams setpoints at 20 Hz of wall time: 4 Hz for the vehicle
NEXT_S = 5.0  # telemetry comes many times a second


class Latest:
    """Wait until a subscription delivers something that meets a condition."""

    def __init__(self, subscribe: Callable[[Callable[[Any, Any], None]], Any]) -> None:
        self._values: queue.SimpleQueue[Any] = queue.SimpleQueue()
        subscribe(lambda value, _: self._values.put(value))

    def until(self, condition: Callable[[Any], bool], what: str, *, timeout_s: float) -> Any:
        deadline_s = time.monotonic() + timeout_s
        value = None
        try:
            while value is None or not condition(value):
                value = self._values.get(timeout=max(0.0, deadline_s - time.monotonic()))
        except queue.Empty:
            raise AssertionError(f"{what}: not within {timeout_s:g} s, last {value}") from None
        return value

    def next(self) -> Any:
        """What comes after this call; what came before is forgotten."""
        self.drain()
        return self._values.get(timeout=NEXT_S)

    def drain(self) -> list[Any]:
        """All that has come and was not looked at."""
        values = []
        with contextlib.suppress(queue.Empty):
            while True:
                values.append(self._values.get_nowait())
        return values


@contextlib.contextmanager
def found_vehicle(folder: Path, *options: str) -> Iterator[System]:
    """Start a vehicle at `SPEED_FACTOR`, and let MAVSDK find it as a ground station would."""
    options = ("--noise=0,0", f"--speed-factor={SPEED_FACTOR}", *options)
    with free_instance() as instance:
        log = folder / "vehicle.txt"
        with process("sitl", f"--instance={instance}", *options, log=log):
            kind = Configuration.create_with_component_type(ComponentType.GROUND_STATION)
            with Mavsdk(kind) as mavsdk:
                mavsdk.add_any_connection(f"udpin://127.0.0.1:{API_PORT + instance}")
                found = mavsdk.first_autopilot(timeout_s=10.0)
                assert found is not None, log.read_text()
                yield found
            kind.destroy()
