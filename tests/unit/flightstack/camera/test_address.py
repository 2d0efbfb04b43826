"""A camera's address is a stranger's word: only one that leads to the vehicle is opened."""

import re

import pytest

from flightstack.camera.address import check_address
from flightstack.errors import LinkError

VEHICLE = "10.41.10.2"


@pytest.mark.parametrize(
    "uri",
    [
        "http://10.41.10.2:8090/stream",
        "https://10.41.10.2/stream?quality=9",
        "HTTP://10.41.10.2/",
        "rtsp://10.41.10.2:8554/front",
        "udp://10.41.10.2:5600",
        "rtp://10.41.10.2:5600",
    ],
)
def test_streams_of_the_vehicle_are_opened(uri: str) -> None:
    check_address(uri, VEHICLE)


@pytest.mark.parametrize(
    "uri",
    [
        *("", " ", "0", "/dev/video0", "flight.mp4", "file:///etc/passwd", "file:x", "5600"),
        "subfile:,start,0,end,9,,:/etc/passwd",
        "concat:/etc/passwd|/etc/group",
        *("gopher://10.41.10.2/", "tcp://10.41.10.2:22", "data:text/plain,x", "hls+http://x/y"),
        *("http://10.41.10.2.evil.org/", "http://evil.org#@10.41.10.2/", "http://evil.org\\@x/"),
        *("http://10.41.10.2@evil.org/", "http://user:secret@10.41.10.2/", "http://[::1/"),
        *("http://127.0.0.1:8090/stream", "http://localhost/", "http://[::1]/", "http://0/"),
        *("http://169.254.169.254/latest", "http://10.41.10.3/", "http:///stream", "http://"),
        *("http://10.41.10.2:99999/", "http://10.41.10.2:x/", "http://10.41.10.2/\x1b[2J"),
        *("http://10.41.10.2/a b", "http://10.41.10.2/\r\nX: y", "http://\uff110.41.10.2/"),
    ],
)
def test_everything_else_is_refused_in_one_line(uri: str) -> None:
    with pytest.raises(LinkError) as refusal:
        check_address(uri, VEHICLE)
    assert re.fullmatch(r"the vehicle names the camera .*", str(refusal.value))
    assert str(refusal.value).isprintable()


@pytest.mark.parametrize(
    ("uri", "camera_host"),
    [
        ("rtsp://10.41.10.3:8554/front", "10.41.10.3"),
        ("rtsp://Camera.Local./front", "camera.local"),
        ("http://[fe80::1]:80/", "FE80:0::1"),
        ("http://localhost:1/", "127.0.0.1"),
    ],
)
def test_another_host_is_allowed_by_name(uri: str, camera_host: str) -> None:
    check_address(uri, VEHICLE, camera_host)
    with pytest.raises(LinkError, match=r"not the vehicle's own host \(10\.41\.10\.2\).*--camera"):
        check_address(uri, VEHICLE)


def test_a_vehicle_on_a_serial_line_has_no_host() -> None:
    with pytest.raises(LinkError, match="the vehicle has no address of its own"):
        check_address("http://127.0.0.1/", None)
    check_address("http://127.0.0.1/", None, "127.0.0.1")
