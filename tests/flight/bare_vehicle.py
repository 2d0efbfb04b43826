"""The simulated vehicle as a real one would be met: no camera component, no referee, a cable."""

import contextlib
import os
import select
import socket
import threading
import tty
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from pymavlink.dialects.v20 import common

from flightstack.launch.instances import CAMERA_PORT, free_instance
from flightstack.mavlink.packets import PacketSplitter, message_id, source_of, split_packets
from tests.flight.processes import process
from tests.wire.companion.companion_trial import free_port
from tests.wire.proxy import Hook, Proxy

AUTOPILOT = 1
GROUND_STATION_PORTS = (18570, 15550)  # + instance; not 14550, where somebody may be listening
READ_BYTES = 65536


@dataclass(frozen=True, slots=True, kw_only=True)
class BareVehicle:
    """Where a companion finds it."""

    port: int  # it sends there, over UDP
    camera: str  # a stream that any player opens, without stamps
    instance: int


def autopilot_only(datagram: bytes) -> list[bytes]:
    """Let through what a PX4 itself says."""
    packets = split_packets(datagram)[0]
    kept = b"".join(packet for packet in packets if source_of(packet)[1] == AUTOPILOT)
    return [kept] if kept else []


def indoors(datagram: bytes) -> list[bytes]:
    """Let through what a PX4 says that has no position: it is not ready to be armed."""
    codec = common.MAVLink(None)
    kept = b""
    for packet in split_packets(b"".join(autopilot_only(datagram)))[0]:
        if message_id(packet) == common.MAVLINK_MSG_ID_HEARTBEAT:
            beat = codec.decode(bytearray(packet))
            beat.system_status = common.MAV_STATE_UNINIT
            codec.srcSystem, codec.srcComponent, codec.seq = *source_of(packet), packet[4]
            kept += beat.pack(codec)
        else:
            kept += packet
    return [kept] if kept else []


@contextlib.contextmanager
def bare_vehicle(
    folder: Path, *options: str, place: Hook = autopilot_only
) -> Iterator[BareVehicle]:
    """Start a vehicle whose offboard link reaches a free port through a filter."""
    port = free_port()
    with free_instance() as instance, Proxy(port, to_companion=place) as proxy:
        local, remote = (number + instance for number in GROUND_STATION_PORTS)
        links = (f"--gcs-link={local}:{remote}", f"--api-link=0:{proxy.vehicle_port}")
        fixed = (f"--instance={instance}", "--noise=0,0", *links)
        with process("sitl", *fixed, *options, log=folder / "vehicle.txt"):
            camera = f"http://127.0.0.1:{CAMERA_PORT + instance}/stream.mjpg"
            yield BareVehicle(port=port, camera=camera, instance=instance)


class SerialLine:
    """A cable between a UDP port on which a vehicle is heard, and a terminal device."""

    def __init__(self, port: int) -> None:
        self._master, self._slave = os.openpty()
        for end in (self._master, self._slave):
            tty.setraw(end)
        os.set_blocking(self._master, False)
        self.device = os.ttyname(self._slave)
        self._port = port
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> "SerialLine":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join(5)
        os.close(self._master)
        os.close(self._slave)

    def _run(self) -> None:
        splitter, vehicle = PacketSplitter(), None
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as udp:
            udp.bind(("127.0.0.1", self._port))
            while not self._stop.is_set():
                ready, _, _ = select.select([udp.fileno(), self._master], [], [], 0.1)
                if udp.fileno() in ready:
                    datagram, vehicle = udp.recvfrom(READ_BYTES)
                    with contextlib.suppress(BlockingIOError):  # nobody reads: lost, as on a cable
                        os.write(self._master, datagram)
                if self._master in ready:
                    for packet in splitter.split(os.read(self._master, READ_BYTES)):
                        if vehicle is not None:
                            udp.sendto(packet, vehicle)
