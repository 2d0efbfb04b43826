"""Read connection strings as users write them: pymavlink's, MAVSDK's, or a bare port.

14550, udpin:host:port, udp:host:port, udpin://host:port, udp://:port     listen for the vehicle
udpout:host:port, udpout://host:port                                      send to the vehicle first
tcp:host:port, tcp://host:port, tcpout://host:port                        connect to a TCP server
/dev/ttyACM0,921600, serial:/dev/ttyACM0:57600, serial:///dev/tty..:57600 open a serial line
"""

import re
from dataclasses import dataclass
from enum import Enum

from flightstack.errors import UsageError

ANY_HOST = "0.0.0.0"  # noqa: S104  (a vehicle may stand on another machine)
DEFAULT_BAUD = 57600  # PX4 SER_TEL1_BAUD
EXAMPLES = "14550, udpin:0.0.0.0:14540, udpout:host:port, tcp:host:port or /dev/ttyACM0,921600"


class Kind(Enum):
    """How an endpoint is opened."""

    UDP_LISTEN = "udpin"
    UDP_SEND = "udpout"
    TCP = "tcp"
    SERIAL = "serial"


@dataclass(frozen=True, slots=True, kw_only=True)
class Endpoint:
    """Where a vehicle is reached: host and port, or device and baud rate."""

    kind: Kind
    host: str  # the device of a serial line
    port: int  # the baud rate of a serial line

    def __str__(self) -> str:
        return f"{self.kind.value}:{self.host}:{self.port}"


SCHEMES = {
    "udp": Kind.UDP_LISTEN,
    "udpin": Kind.UDP_LISTEN,
    "udpout": Kind.UDP_SEND,
    "tcp": Kind.TCP,
    "tcpout": Kind.TCP,
}
NETWORK = re.compile(r"(?P<scheme>[a-z]+):(//)?(?P<host>[^:/]*):(?P<port>\d+)")
SERIAL = re.compile(
    r"(?:serial:(?://)?)?(?P<device>/[^,:]+|COM\d+|tty\w+)(?:[,:](?P<baud>\d+))?", re.IGNORECASE
)


def parse_endpoint(text: str) -> Endpoint:
    """Read a connection string; raises UsageError with examples of good ones."""
    if text.isdecimal():
        return _network(text, Kind.UDP_LISTEN, "", text)
    if found := NETWORK.fullmatch(text):
        kind = SCHEMES.get(found["scheme"])
        if kind is not None:
            return _network(text, kind, found["host"], found["port"])
    if found := SERIAL.fullmatch(text):
        baud = int(found["baud"] or DEFAULT_BAUD)
        if baud > 0:
            return Endpoint(kind=Kind.SERIAL, host=found["device"], port=baud)
    raise UsageError(f"connection string {text!r} is not understood; write {EXAMPLES}")


def _network(text: str, kind: Kind, host: str, port_text: str) -> Endpoint:
    port = int(port_text)
    if not 1 <= port <= 65535:
        raise UsageError(f"connection string {text!r}: port {port} is not within 1 to 65535")
    if kind is not Kind.UDP_LISTEN and not host:
        raise UsageError(f"connection string {text!r} lacks a host; write {EXAMPLES}")
    return Endpoint(kind=kind, host=host or ANY_HOST, port=port)
