"""Feed the companion's parsers: telemetry, raw bytes, its camera, logs, files, addresses."""

import atexit
import io
import shutil
import tempfile
from collections.abc import Callable
from pathlib import Path

import numpy as np
from pymavlink.dialects.v20 import common

from flightstack.camera.address import check_address
from flightstack.camera.parts import decode_rgb, read_number, read_part, read_stamp_us
from flightstack.clock import VehicleClock
from flightstack.companion.console import Console
from flightstack.companion.mission.machine import advance
from flightstack.companion.mission.records import MissionPhase, MissionStatus, Situation
from flightstack.companion.reporter import Reporter
from flightstack.companion.vehicle_session import VehicleSession
from flightstack.errors import LinkError, ModelError, UsageError
from flightstack.logs import LogFileError, read_bytes
from flightstack.logs.checks import run_checks
from flightstack.logs.facts.summary import summarise
from flightstack.logs.flight.flight import Flight
from flightstack.mavlink.endpoint import parse_endpoint
from flightstack.mavlink.link import Link
from flightstack.mavlink.packets import PacketSplitter, split_packets
from flightstack.mavlink.signing import Signing
from flightstack.mavlink.tlog import TlogWriter
from flightstack.mavlink.transport import Address, Received
from flightstack.models import ModelConfig
from flightstack.px4_modes import Px4Mode
from flightstack.tables import read_toml, record_from_table
from scripts.fuzz.packets import packets_of

VEHICLE: Address = ("127.0.0.1", 14580)
KINDS = [kind for _, kind in sorted(common.mavlink_map.items())]
HEARD = [kind for kind in KINDS if kind.id in (0, 1, 22, 24, 30, 31, 32, 33, 42, 46, 44, 73, 77)]
HEARD += [kind for kind in KINDS if kind.id in (51, 112, 147, 242, 245, 253, 269)]
COMPONENTS = (1, 1, 1, 25, 100, 191, 0)
STEP_US = 50_000
KEY = bytes(32)


class Silence(io.StringIO):
    """A console's stream that nobody reads."""

    def write(self, text: str) -> int:
        """Check what is said, and forget it."""
        if not text.removesuffix("\n").isprintable():
            raise AssertionError(f"a terminal would obey {text!r}")
        return len(text)


class MemoryTransport:
    """A transport that delivers what it was given."""

    def __init__(self) -> None:
        self.closed = False
        self.waiting: list[Received] = []

    def fileno(self) -> int:
        """Never waited on."""
        return -1

    def receive(self) -> list[Received]:
        """Return what waits."""
        waiting, self.waiting = self.waiting, []
        return waiting

    def forget_backlog(self) -> None:
        """There is none."""

    def listen_only_to(self, partner: Address | None) -> None:
        """Nobody else is there."""

    def send(self, packets: bytes, address: Address | None) -> bool:  # noqa: ARG002
        """Lose it."""
        return True

    def close(self) -> None:
        """Close nothing."""


class Companion:
    """A session on a link that is in memory, at some phase of its mission."""

    def __init__(self, phase: MissionPhase) -> None:
        self.transport = MemoryTransport()
        self.clock = VehicleClock(lambda: 0.0)
        self.link = Link(self.transport, _TLOG, self.clock)
        self.session = VehicleSession(self.link, 3.0)
        self.reporter = Reporter(Console(verbosity=1, stream=Silence()))
        self.status = MissionStatus(phase=phase, entered_us=0, offboard_us=0)
        beat = common.MAVLink_heartbeat_message(2, 12, 128 | 29, Px4Mode.OFFBOARD, 4, 3)
        self.hear(bytes(beat.pack(common.MAVLink(None, 1, 1))))

    def hear(self, *packets: bytes) -> None:
        """Take packets in, and let the mission move on by what is then known."""
        self.transport.waiting.append((split_packets(b"".join(packets))[0], VEHICLE))
        self.session.receive()
        now_us = self.clock.stamp_us
        situation = Situation(vehicle=self.session.telemetry, image_us=now_us)
        self.status, requests = advance(self.status, situation, now_us)
        for request in requests:
            self.session.request(request, now_us)
        self.session.keep_up(now_us)
        self.session.download_course(now_us)
        self.reporter.report(self.status, self.session)


def telemetry(data: bytes) -> None:
    """Hear whole packets of any content from the vehicle, in any phase."""
    phases = list(MissionPhase)
    companion = Companion(phases[data[0] % len(phases)] if data else MissionPhase.FLYING)
    for packet in packets_of(data[1:], HEARD, system=1, components=COMPONENTS):
        companion.hear(packet)


def any_telemetry(data: bytes) -> None:
    """Hear any message of the dialect, all at once."""
    packets = packets_of(data, KINDS, system=1, components=COMPONENTS)
    Companion(MissionPhase.FLYING).hear(*packets)


def link_bytes(data: bytes) -> None:
    """Cut raw bytes, whole and in pieces, and judge their signatures."""
    whole, used = split_packets(data)
    if not 0 <= used <= len(data):
        raise AssertionError(f"{used} of {len(data)} bytes used")
    splitter, signing = PacketSplitter(), Signing(KEY)
    half = len(data) // 2
    for packet in (*whole, *splitter.split(data[:half]), *splitter.split(data[half:])):
        signing.verify(packet)
    Companion(MissionPhase.FLYING).hear(data)


def camera_parts(data: bytes) -> None:
    """Read a stream's parts, and decode whatever is in them."""
    stream = io.BytesIO(data)
    try:
        while True:
            headers, content = read_part(stream)
            decode_rgb(content)
            read_stamp_us(headers.get("x-timestamp", ""))
            read_number(headers.get("x-sequence", ""), 0)
    except OSError:
        return


def camera_picture(data: bytes) -> None:
    """Decode bytes as a picture."""
    decode_rgb(data)


def tlog(data: bytes) -> None:
    """Read a log, and say all about it."""
    with np.errstate(all="ignore"):
        try:
            flight = Flight(read_bytes(data))
        except LogFileError:
            return
        summarise(flight, run_checks(flight))


def model_config(data: bytes) -> None:
    """Read a model's configuration."""
    try:
        table = read_toml(data.decode(), where="config.toml")
        record_from_table(ModelConfig, table, where="config.toml")
    except (ValueError, ModelError):
        return


def addresses(data: bytes) -> None:
    """Read connection strings and cameras' addresses."""
    text = data.decode("utf-8", "replace")
    try:
        check_address(text, "127.0.0.1", "camera.local")
    except LinkError as refusal:
        if not str(refusal).isprintable():
            raise AssertionError(str(refusal)) from refusal
    try:
        parse_endpoint(text)
    except UsageError:
        return


class _Forgetful(TlogWriter):
    """A log that keeps nothing."""

    def append(self, elapsed_us: int, packet: bytes) -> None:
        """Check that it could be kept."""
        super().append(elapsed_us, packet)
        self._pending.clear()


def _log() -> TlogWriter:
    folder = Path(tempfile.mkdtemp(prefix="fuzz-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    return _Forgetful(folder / "fuzz.tlog", lambda: 0.0)


_TLOG = _log()
TARGETS: dict[str, Callable[[bytes], None]] = {
    "telemetry": telemetry,
    "any-telemetry": any_telemetry,
    "link-bytes": link_bytes,
    "camera-parts": camera_parts,
    "camera-picture": camera_picture,
    "tlog": tlog,
    "model-config": model_config,
    "addresses": addresses,
}
