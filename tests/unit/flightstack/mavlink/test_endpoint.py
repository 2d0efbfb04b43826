"""Connection strings, as pymavlink's and MAVSDK's users write them."""

import pytest

from flightstack.errors import UsageError
from flightstack.mavlink.endpoint import ANY_HOST, Endpoint, Kind, parse_endpoint


@pytest.mark.parametrize(
    ("text", "kind", "host", "port"),
    [
        ("14550", Kind.UDP_LISTEN, ANY_HOST, 14550),
        ("udp:127.0.0.1:14540", Kind.UDP_LISTEN, "127.0.0.1", 14540),
        ("udpin:0.0.0.0:14550", Kind.UDP_LISTEN, ANY_HOST, 14550),
        ("udpin://0.0.0.0:14540", Kind.UDP_LISTEN, ANY_HOST, 14540),
        ("udp://:14540", Kind.UDP_LISTEN, ANY_HOST, 14540),
        ("udpout:10.0.0.2:14580", Kind.UDP_SEND, "10.0.0.2", 14580),
        ("udpout://drone.local:14580", Kind.UDP_SEND, "drone.local", 14580),
        ("tcp:localhost:5760", Kind.TCP, "localhost", 5760),
        ("tcpout://localhost:5760", Kind.TCP, "localhost", 5760),
        ("/dev/ttyACM0,921600", Kind.SERIAL, "/dev/ttyACM0", 921600),
        ("/dev/ttyACM0", Kind.SERIAL, "/dev/ttyACM0", 57600),
        ("serial:///dev/ttyUSB0:115200", Kind.SERIAL, "/dev/ttyUSB0", 115200),
        ("serial:/dev/ttyUSB0:115200", Kind.SERIAL, "/dev/ttyUSB0", 115200),
    ],
)
def test_reads_what_users_write(text: str, kind: Kind, host: str, port: int) -> None:
    assert parse_endpoint(text) == Endpoint(kind=kind, host=host, port=port)


@pytest.mark.parametrize(
    "text",
    [
        *("", "nonsense", "udp:host", "udpin::", "99999", "0", "-1", "1e4", "ftp://host:21"),
        *("udpout::14550", "tcp://:5760", "udp:a:b:1", "/dev/ttyACM0,fast", "/dev/ttyACM0,0"),
    ],
)
def test_refuses_what_means_nothing(text: str) -> None:
    with pytest.raises(UsageError) as refusal:
        parse_endpoint(text)
    assert repr(text) in str(refusal.value)
    assert "\n" not in str(refusal.value)
