"""Listen on a UDP port for a camera that sends H.264 over bare RTP, as ground stations do."""

import contextlib
import ipaddress
import socket
from fractions import Fraction
from typing import Any
from urllib.parse import urlsplit

from flightstack.camera.mailbox import Arrival
from flightstack.camera.video.decoded import ImageDater, make_prompt
from flightstack.camera.video.rtp import TICK_S, CodedPicture, PictureAssembler, is_rtp
from flightstack.clock import VehicleClock
from flightstack.libraries import load_library

DATAGRAM_BYTES = 65535
BUFFER_BYTES = 1 << 21  # of the socket: whole pictures come in bursts
READ_TIMEOUT_S = 5.0
ANY = "0.0.0.0"  # noqa: S104  (where a camera's packets may come in; the user names the port)
TICK = Fraction(1, 90_000)


class RtpSource:
    """One port, and the decoder of what comes in; the first sender is the camera."""

    def __init__(self, listener: socket.socket, clock: VehicleClock) -> None:
        """Take over a port on which RTP arrives; raises MissingLibraryError without PyAV."""
        self._av: Any = load_library("av", "video")
        self._listener = listener
        self._clock = clock
        self._camera: Any = None  # its address
        self._assembler = PictureAssembler()
        self._decoder = self._av.CodecContext.create("h264", "r")
        make_prompt(self._av, self._decoder)
        self._dater = ImageDater(clock)
        self._is_closed = False
        listener.settimeout(READ_TIMEOUT_S)

    def read(self) -> Arrival:
        """Wait for the next image; raises OSError when none comes for 5 s."""
        while True:
            picture = self._receive()
            received_s = self._clock.wall_s()
            if picture is None:
                continue
            frame = self._decode(picture)
            if frame is not None:
                stamp_s = None if frame.pts is None else frame.pts * TICK_S
                return self._dater.arrival(frame, stamp_s, received_s)

    def close(self) -> None:
        """End reading; a `read` that waits in another thread raises OSError."""
        self._is_closed = True
        with contextlib.suppress(OSError):
            self._listener.shutdown(socket.SHUT_RDWR)
        self._listener.close()

    def _receive(self) -> CodedPicture | None:
        packet, sender = self._listener.recvfrom(DATAGRAM_BYTES)
        if self._is_closed:
            raise OSError(0, "the camera is closed")
        self._camera = self._camera or sender
        return self._assembler.take(packet) if sender == self._camera else None

    def _decode(self, picture: CodedPicture) -> Any:
        """Return the newest frame that this picture makes whole; None where it makes none."""
        packet = self._av.Packet(picture.data)
        packet.pts, packet.time_base = round(picture.stamp_s / TICK_S), TICK
        try:
            frames = self._decoder.decode(packet)
        except self._av.error.InvalidDataError:
            return None
        return frames[-1] if frames else None


def listen_for_rtp(uri: str, timeout_s: float) -> socket.socket | None:
    """Wait for the first packet at udp:// or rtp://; return the port, None where it is no RTP.

    Raises OSError where nothing arrives in time, or the port cannot be had.
    """
    parts = urlsplit(uri)
    host, port = parts.hostname or ANY, parts.port
    if port is None:
        raise OSError(0, "name the port that the video comes to, as udp://0.0.0.0:5600")
    listener = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    try:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, BUFFER_BYTES)
        listener.settimeout(timeout_s)
        listener.bind((host, port))
        with contextlib.suppress(ValueError):
            if ipaddress.ip_address(host).is_multicast:
                group = socket.inet_aton(host) + socket.inet_aton(ANY)
                listener.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, group)
        if is_rtp(listener.recv(DATAGRAM_BYTES)):
            return listener
    except TimeoutError:
        listener.close()
        raise OSError(0, f"nothing arrives at UDP port {port}") from None
    except OSError:
        listener.close()
        raise
    listener.close()
    return None
