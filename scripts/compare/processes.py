"""Start a commit's vehicle and companion from the command line, on ports that are free."""

import contextlib
import os
import socket
import subprocess
import sys
import time
from collections import deque
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Self

from flightstack.launch.processes import Process, Program, running
from scripts.compare.messages import Message, Reader

PATIENCE_S = 30.0  # wall time
ENDS_S = 5.0  # after SIGTERM


class Link:
    """A UDP port of ours that a vehicle's link, or a companion's, speaks to."""

    def __init__(self) -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 1 << 22)
        self._socket.bind(("127.0.0.1", 0))
        self.port: int = self._socket.getsockname()[1]
        self.peer: tuple[str, int] | None = None
        self._datagram = b""
        self._pending: deque[Message] = deque()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._socket.close()

    def fileno(self) -> int:
        """Let it be selected."""
        return self._socket.fileno()

    def send(self, datagram: bytes) -> None:
        """Send to whoever was heard last."""
        if self.peer is not None:
            self._socket.sendto(datagram, self.peer)

    def receive(self, patience_s: float) -> bytes:
        """Wait for a datagram; empty if none comes."""
        self._socket.settimeout(patience_s)
        try:
            self._datagram, self.peer = self._socket.recvfrom(1 << 16)
        except TimeoutError:
            return b""
        return self._datagram

    def pending(self, reader: Reader, name: str) -> Iterator[Message]:
        """Give, one by one, the messages of the last datagram that were not given yet."""
        self._pending.extend(reader.read(self._datagram, name))
        self._datagram = b""
        while self._pending:
            yield self._pending.popleft()


def vehicle_command(gcs_port: int, api_port: int, *options: str) -> list[str]:
    """Spell out a vehicle in lockstep, as fast as it can, that speaks to these ports."""
    return [
        *(sys.executable, "-m", "sitl", "--lockstep", "--speed-factor=0", "-q"),
        *(f"--gcs-link=0:{gcs_port}", f"--api-link=0:{api_port}", "--camera-port=0", *options),
    ]


def companion_command(port: int, log: Path, *options: str) -> list[str]:
    """Spell out a companion that listens on a port."""
    return [
        *(sys.executable, "-m", "flightstack.companion", f"--udp={port}", f"--log={log}"),
        *("--json", "-q", *options),
    ]


@contextlib.contextmanager
def started(
    root: Path, command: list[str], variables: Mapping[str, str] | None = None
) -> Iterator[Process]:
    """Run a command with the code at `root`; on any way out, end it."""
    inherited = {name: value for name, value in os.environ.items() if not name.startswith("PX4_")}
    settled = {"PYTHONPATH": str(root), "OMP_NUM_THREADS": "1", **(variables or {})}
    program = Program(
        command=command,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        environment=inherited | settled,
        folder=root,
    )
    with running(program, ends_s=ENDS_S) as process:
        yield process


def free_port() -> int:
    """Find a UDP port that nobody has."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


def wait_until_bound(port: int, process: Process) -> None:
    """Wait until somebody listens on a UDP port; looks without touching it."""
    deadline_s = time.monotonic() + PATIENCE_S
    while f":{port:04X} " not in Path("/proc/net/udp").read_text():
        if process.poll() is not None or time.monotonic() > deadline_s:
            raise ConnectionError(f"nobody listens on UDP port {port}")
        time.sleep(0.02)
