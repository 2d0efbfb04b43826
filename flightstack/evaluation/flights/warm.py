"""Keep one fork server at hand, and hand it flights."""

import contextlib
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

from flightstack.evaluation.flights.errors import FlightDiedError

MODULE = "flightstack.evaluation.flights.fork_server"
ENDS_S = 5.0
BANNER = "pybullet build time:"


class WarmServer:
    """One fork server, from the first flight until `close`; not for several threads."""

    def __init__(self) -> None:
        path = os.pathsep.join(filter(None, sys.path))  # a user's own policy is found there, too
        self._complaints = tempfile.TemporaryFile("w+")  # noqa: SIM115  closed by close
        self._process = subprocess.Popen(  # noqa: S603  our own program
            [sys.executable, "-m", MODULE],
            env=os.environ | {"OMP_NUM_THREADS": "1", "PYTHONPATH": path},
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

    def fly(self, order: dict[str, Any]) -> dict[str, int | None]:
        """Fly; returns how each process ended. Raises FlightDiedError where the server did."""
        pipe = self._process.stdin
        with contextlib.suppress(BrokenPipeError):
            if pipe is not None:
                pipe.write(json.dumps(order) + "\n")
                pipe.flush()
        return self._hear()

    def close(self) -> None:
        """End it, and a flight that is under way."""
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


def last_line(text: str) -> str:
    """Pick the last line that is no library's banner, or say that there is none."""
    lines = [line for line in text.splitlines() if line.strip() and not line.startswith(BANNER)]
    return lines[-1] if lines else "it said nothing"


def words_of(folder: Path, name: str) -> str:
    """Read what a process wrote to standard error."""
    path = folder / f"{name}.err"
    return path.read_text(errors="replace") if path.exists() else ""
