"""A vehicle as MAVSDK sees it: a real process, found over its API link.

Vehicle time passes `SPEED_FACTOR` times as fast as a clock's, or slower on a busy host: what takes
so long is measured by the vehicle's own stamps.
"""

import contextlib
import queue
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

from mavsdk import ComponentType, Configuration, Mavsdk, System
from mavsdk.plugins.telemetry import Telemetry

from flightstack.launch.instances import API_PORT, free_instance
from tests.flight.processes import process

SPEED_FACTOR = 5.0  # MAVSDK streams setpoints at 20 Hz of wall time: 4 Hz for the vehicle
NEXT_S = 5.0  # telemetry comes many times a second
PATIENCE_S = 60.0  # wall time for what takes some seconds of vehicle time
Vector3 = tuple[float, float, float]


class Latest:
    """Wait until a subscription delivers something that meets a condition."""

    def __init__(self, subscribe: Callable[[Callable[[Any, Any], None]], Any]) -> None:
        self._values: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._subscribe = subscribe  # its plugin lives as long as somebody knows it
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
        return self.pop()

    def pop(self) -> Any:
        """The oldest that was not looked at."""
        return self._values.get(timeout=NEXT_S)

    def drain(self) -> list[Any]:
        """All that has come and was not looked at."""
        values = []
        with contextlib.suppress(queue.Empty):
            while True:
                values.append(self._values.get_nowait())
        return values


class Motion(NamedTuple):
    """Where the vehicle is, and how fast, local NED."""

    time_s: float  # of the vehicle
    place_ned: Vector3  # m
    velocity_ned: Vector3  # m/s


class Track:
    """The vehicle's motion, as MAVSDK hears it in ODOMETRY."""

    def __init__(self, telemetry: Telemetry) -> None:
        self._odometry = Latest(telemetry.subscribe_odometry)

    def now(self) -> Motion:
        """What comes after this call."""
        return _motion(self._odometry.next())

    def until(self, condition: Callable[[Motion], bool], what: str, *, within_s: float) -> Motion:
        """The first motion that meets the condition; it fails after that much vehicle time."""
        start_s = self.now().time_s

        def ends(sample: Any) -> bool:
            motion = _motion(sample)
            return condition(motion) or motion.time_s > start_s + within_s

        motion = _motion(self._odometry.until(ends, what, timeout_s=PATIENCE_S))
        assert condition(motion), f"{what}: not within {within_s:g} s of flight, at {motion}"
        return motion

    def drain(self) -> list[Motion]:
        """All that has come and was not looked at."""
        return [_motion(sample) for sample in self._odometry.drain()]

    def wait(self, seconds: float) -> list[Motion]:
        """All that comes in some vehicle time."""
        motions = [self.now()]
        while motions[-1].time_s < motions[0].time_s + seconds:
            motions += [_motion(self._odometry.pop()), *self.drain()]
        return motions


def _motion(sample: Any) -> Motion:
    at, velocity = sample.position_body, sample.velocity_body  # in both frames NED
    return Motion(
        sample.time_usec / 1e6,
        (at.x_m, at.y_m, at.z_m),
        (velocity.x_m_s, velocity.y_m_s, velocity.z_m_s),
    )


@contextlib.contextmanager
def found_vehicle(folder: Path, *options: str, module: str = "sitl") -> Iterator[System]:
    """Start a vehicle at `SPEED_FACTOR`, and let MAVSDK find it as a ground station would."""
    options = ("--noise=0,0", f"--speed-factor={SPEED_FACTOR}", *options)
    with free_instance() as instance:
        log = folder / "vehicle.txt"
        with process(module, f"--instance={instance}", *options, log=log):
            kind = Configuration.create_with_component_type(ComponentType.GROUND_STATION)
            with Mavsdk(kind) as mavsdk:
                mavsdk.add_any_connection(f"udpin://127.0.0.1:{API_PORT + instance}")
                found = mavsdk.first_autopilot(timeout_s=10.0)
                assert found is not None, log.read_text()
                yield found
            kind.destroy()
