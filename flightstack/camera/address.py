"""Judge the camera address that a vehicle names: it is a stranger's until it leads to the vehicle.

Whoever can speak on the link can name any address. Opened without a look, it would read local files
(`file:`, `concat:`, a playlist), or reach into the companion's own network.
"""

import ipaddress
from urllib.parse import urlsplit

from flightstack.errors import LinkError

SCHEMES = ("http", "https", "rtsp", "rtsps", "udp", "rtp")
LOOPBACK = "127.0.0.1"


def check_address(uri: str, vehicle_host: str | None, camera_host: str | None = None) -> None:
    """Refuse an address that does not lead to the vehicle's own host, or to `camera_host`.

    `vehicle_host` is where the vehicle's packets come from, None on a serial line. Raises
    LinkError, in one line.
    """
    try:
        parts = urlsplit(uri)
        host, _ = parts.hostname, parts.port  # a port that is none raises
    except ValueError:
        raise _refusal(uri, "that is no address") from None
    if not uri.isascii() or not uri.isprintable() or " " in uri:
        raise _refusal(uri, "that is no address")
    if parts.scheme not in SCHEMES:
        raise _refusal(uri, f"only {', '.join(SCHEMES[:-1])} and {SCHEMES[-1]} are opened unasked")
    if parts.username is not None or not host:
        raise _refusal(uri, "it must be a host alone, without a user's name")
    if _same(host, camera_host) or _same(host, vehicle_host):
        return
    where = "the vehicle has no address of its own" if vehicle_host is None else vehicle_host
    raise _refusal(uri, f"that is not the vehicle's own host ({where}); allow it by --camera-host")


def _same(host: str, other: str | None) -> bool:
    return other is not None and _plain(host) == _plain(other)


def _plain(host: str) -> str:
    """Write a host in one way only: names in lower case, addresses as they are printed."""
    name = host.lower().rstrip(".")
    try:
        return str(ipaddress.ip_address(LOOPBACK if name == "localhost" else name))
    except ValueError:
        return name


def _refusal(uri: str, why: str) -> LinkError:
    return LinkError(f"the vehicle names the camera {uri!r}: {why}, or open it by --camera")
