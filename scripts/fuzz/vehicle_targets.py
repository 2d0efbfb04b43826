"""Feed the vehicle's parsers: commands, parameters, missions, files, its camera's port."""

import atexit
import shutil
import tempfile
from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from scripts.fuzz.packets import packets_of
from sitl import Simulation, SimulationConfig
from sitl.errors import UsageError
from sitl.mavlink.components.camera_component import CameraFacts
from sitl.mavlink.endpoint import Endpoint
from sitl.mavlink.links.link import Link
from sitl.mavlink.servers.files.storage import Storage
from sitl.mavlink.wire.dialect import mavlink
from sitl.mavlink.wire.packets import Received, split, split_stream
from sitl.process.quiet import quiet_outputs
from sitl.process.streams.http_stream import MAX_REQUEST_BYTES, answer, is_complete
from sitl.records.conditions import parse_conditions
from sitl.toml_records import parse_toml

FACTS = CameraFacts(
    stream_uri="http://127.0.0.1:1/stream",
    width_px=64,
    height_px=64,
    field_of_view_deg=90,
    rate_hz=20.0,
)
COMPONENTS = (190, 191, 1, 0, 25, 100, 255)
SYSTEM = 1
TICKS = 3  # that pass after each packet
SIGNING = mavlink.MAVLINK_MSG_ID_SETUP_SIGNING  # would shut the fuzzer out
KINDS = [kind for number, kind in sorted(mavlink.mavlink_map.items()) if number != SIGNING]


class MemoryLink(Link):
    """A link that delivers what it was given, and keeps nothing of what is sent."""

    def __init__(self, index: int) -> None:
        super().__init__(str(index), system=SYSTEM, index=index)
        self.waiting: list[bytes] = []

    def close(self) -> None:
        """Close nothing."""

    def fileno(self) -> int:
        """Never waited on."""
        return -1

    def describe(self) -> str:
        """Name it."""
        return self.name

    def _transmit(self, data: bytes) -> None:
        if split(data) == []:
            raise AssertionError(f"the vehicle has sent {data!r}")

    def _take(self) -> list[Received] | None:
        return split(self.waiting.pop(0)) if self.waiting else None

    def _adopt_sender(self) -> None:
        """Keep the one that it has."""


class Vehicle:
    """A simulated vehicle in the air, on two links that are in memory."""

    def __init__(self) -> None:
        with quiet_outputs():
            self.simulation = Simulation(SimulationConfig(seed=1))
        self.simulation.start_airborne((0.0, 0.0, -3.0), 0.0)
        folder = Path(tempfile.mkdtemp(prefix="fuzz-"))
        atexit.register(shutil.rmtree, folder, ignore_errors=True)
        self.links = [MemoryLink(0), MemoryLink(1)]
        self.endpoint = Endpoint(
            self.simulation,
            self.links,
            system=SYSTEM,
            camera=FACTS,
            storage=Storage(folder, clock=lambda: self.simulation.time_us),
        )

    def hear(self, datagram: bytes, link: int = 0) -> None:
        """Take a datagram in, and let a little time pass."""
        self.links[link].waiting.append(datagram)
        while self.endpoint.receive(self.links[link]):
            continue
        for _ in range(TICKS):
            self.endpoint.publish()
            self.simulation.step()


@cache
def _vehicle() -> Vehicle:
    """Make the one that is fuzzed; what one input has done to it, the next finds."""
    return Vehicle()


def _messages(*names: str) -> Callable[[bytes], None]:
    kinds: Sequence[Any] = [k for k in KINDS if not names or k.msgname.startswith(names)]

    def hear(data: bytes) -> None:
        for packet in packets_of(data, kinds, system=255, components=COMPONENTS, target=SYSTEM):
            _vehicle().hear(packet, len(data) % 2)

    return hear


def datagrams(data: bytes) -> None:
    """Hear raw bytes, as a datagram and as two pieces of a stream."""
    _vehicle().hear(data)
    _, rest = split_stream(data[: len(data) // 2])
    split_stream(rest + data[len(data) // 2 :])


def camera_requests(data: bytes) -> None:
    """Answer a request at the camera's port, as far as its buffer would let it come."""
    request = data[:MAX_REQUEST_BYTES]
    if is_complete(request):
        head, coding = answer(request)
        if not head.startswith(b"HTTP/1.1 ") or (coding and b" 200 OK" not in head[:15]):
            raise AssertionError(head)


def conditions(data: bytes) -> None:
    """Read the conditions of a flight."""
    try:
        parse_conditions(parse_toml(data.decode(), "conditions"), "conditions")
    except (UsageError, UnicodeDecodeError):
        return


TARGETS: dict[str, Callable[[bytes], None]] = {
    "commands": _messages("COMMAND_", "SET_", "MANUAL", "HEARTBEAT", "TIMESYNC", "PING", "RC_"),
    "parameters": _messages("PARAM_"),
    "missions": _messages("MISSION_"),
    "files": _messages("FILE_", "LOG_"),
    "any-message": _messages(),
    "datagrams": datagrams,
    "camera-requests": camera_requests,
    "conditions": conditions,
}
