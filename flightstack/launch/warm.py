"""Start flights from one warm process, which has imported already what they need."""

import contextlib
import json
import subprocess
import sys
import tempfile
from typing import Any

from flightstack.launch.errors import FlightDiedError
from flightstack.launch.order import COMPANION, VEHICLE, Ended, Order, last_line
from flightstack.launch.processes import environment

MODULE = "flightstack.launch.fork_server"
ENDS_S = 5.0


class WarmStarter:
    """A `Starter` that keeps one fork server, from the first flight until `close`.

    A flight is over when either of its processes has ended; the other is then killed.
    """

    def __init__(self) -> None:
        self._server: _Server | None = None

    def prepare(self) -> None:
        """Have a server that can take an order."""
        self._ready()

    def fly(self, order: Order) -> Ended:
        """Fly; raises FlightDiedError where the server died."""
        codes = self._ready().order(
            {
                VEHICLE: order.request.vehicle_arguments(order.ports),
                COMPANION: order.request.companion_arguments(order.ports),
                "folder": str(order.folder),
                "limit_s": order.limit_s,
            }
        )
        return Ended(vehicle=codes[VEHICLE], companion=codes[COMPANION], folder=order.folder)

    def _ready(self) -> "_Server":
        if self._server is not None and not self._server.is_alive:
            self.close()
        if self._server is None:
            self._server = _Server()
        return self._server

    def close(self) -> None:
        """End the server, and a flight that is under way."""
        if self._server is not None:
            self._server.close()
            self._server = None


class _Server:
    """The process, and the pipes to it."""

    def __init__(self) -> None:
        self._complaints = tempfile.TemporaryFile("w+")  # noqa: SIM115  closed by close
        self._process = subprocess.Popen(  # noqa: S603  our own program
            [sys.executable, "-m", MODULE],
            env=environment() | {"OMP_NUM_THREADS": "1"},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=self._complaints,
            text=True,
            start_new_session=True,  # a Ctrl-C is for whoever ordered the flights
        )
        self._hear()

    @property
    def is_alive(self) -> bool:
        """Whether it can take an order."""
        return self._process.poll() is None

    def order(self, order: dict[str, Any]) -> dict[str, int | None]:
        """Return how each process of the ordered flight ended."""
        pipe = self._process.stdin
        with contextlib.suppress(BrokenPipeError):
            if pipe is not None:
                pipe.write(json.dumps(order) + "\n")
                pipe.flush()
        return self._hear()

    def close(self) -> None:
        """End it."""
        with contextlib.suppress(BrokenPipeError, subprocess.TimeoutExpired):
            self._process.communicate(timeout=ENDS_S)
        self._process.kill()
        self._process.wait()
        self._complaints.close()

    def _hear(self) -> dict[str, int | None]:
        pipe = self._process.stdout
        line = "" if pipe is None else pipe.readline()
        if not line:
            self._process.kill()
            self._process.wait()
            raise FlightDiedError(f"the fork server died: {self._last_words()}")
        answer: dict[str, int | None] = json.loads(line)
        return answer

    def _last_words(self) -> str:
        self._complaints.seek(0)
        return last_line(self._complaints.read())
