"""Video for ground stations, taken apart by hand and decoded again."""

import socket
import struct
import sys
from collections.abc import Iterator

import numpy as np
import pytest

from sitl.errors import LinkError, UsageError
from sitl.process.streams.video import VideoSender
from sitl.records.images import Image

av = pytest.importorskip("av")
SIZE_PX, RATE_HZ = 64, 20
START = b"\0\0\0\1"  # between the units of an H.264 stream
SINGLE_LAST, AGGREGATE, FRAGMENT = 23, 24, 28  # kinds of payload, RFC 6184


@pytest.fixture
def viewer() -> Iterator[socket.socket]:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as viewer:
        viewer.bind(("127.0.0.1", 0))
        viewer.settimeout(1.0)
        yield viewer


def picture(number: int) -> Image:
    rgb = np.zeros((SIZE_PX, SIZE_PX, 3), np.uint8)
    rgb[:, : 8 * number] = (200, 40, 90)
    return Image(time_us=50_000 * number, sequence=number, rgb=rgb)


def units(payload: bytes) -> bytes:
    """Turn one RTP payload into a piece of the H.264 stream."""
    kind = payload[0] & 0x1F
    if kind <= SINGLE_LAST:
        return START + payload
    if kind == AGGREGATE:
        stream, rest = b"", payload[1:]
        while rest:
            (size,) = struct.unpack(">H", rest[:2])
            stream, rest = stream + START + rest[2 : 2 + size], rest[2 + size :]
        return stream
    assert kind == FRAGMENT
    head = START + bytes(((payload[0] & 0xE0) | (payload[1] & 0x1F),))
    return (head if payload[1] & 0x80 else b"") + payload[2:]


def test_a_ground_station_sees_what_the_camera_sees(viewer: socket.socket) -> None:
    sender = VideoSender(viewer.getsockname(), size_px=SIZE_PX, rate_hz=RATE_HZ)
    stream, stamps, numbers = b"", [], []
    for number in range(5):
        sender.publish(picture(number))
        is_last = 0
        while not is_last:
            packet = viewer.recv(2048)
            version, kind, sequence, stamp = struct.unpack(">BBHI", packet[:8])
            is_last = kind >> 7
            assert (version >> 6, kind & 0x7F) == (2, 96)
            numbers.append(sequence)
            stream += units(packet[12:])
        stamps.append(stamp)
    sender.close()
    assert np.diff(stamps).tolist() == [4500] * 4  # 90 kHz
    assert np.diff(np.array(numbers, np.uint16)).tolist() == [1] * (len(numbers) - 1)
    decoder = av.CodecContext.create("h264", "r")
    packets = [*decoder.parse(stream), *decoder.parse(None)]
    seen = [image for packet in packets for image in decoder.decode(packet)]
    seen += decoder.decode(None)
    assert len(seen) == 5
    for number, image in enumerate(seen):
        small = image.to_ndarray(format="rgb24")[2::4, 2::4].astype(float)
        assert np.abs(small - picture(number).rgb).mean() < 6.0


def test_nobody_need_look(viewer: socket.socket) -> None:
    address = viewer.getsockname()
    viewer.close()
    sender = VideoSender(address, size_px=SIZE_PX, rate_hz=RATE_HZ)
    for number in range(8):
        sender.publish(picture(number))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as late:
        late.bind(address)
        late.settimeout(1.0)
        sender.publish(picture(8))
        assert late.recv(2048)[0] >> 6 == 2  # RTP goes on, to whoever looks now
    sender.close()


def test_it_opens_nothing_on_other_interfaces(viewer: socket.socket) -> None:
    sender = VideoSender(viewer.getsockname(), size_px=SIZE_PX, rate_hz=RATE_HZ)
    sender.publish(picture(0))
    _, (host, port) = viewer.recvfrom(2048)
    assert host == "127.0.0.1"
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.2", port))  # would be taken
    sender.close()


def test_a_host_that_is_not_there_is_said_at_once() -> None:
    with pytest.raises(LinkError, match=r"--video udp://nowhere\.invalid:5600: "):
        VideoSender(("nowhere.invalid", 5600), size_px=SIZE_PX, rate_hz=RATE_HZ)


def test_without_pyav_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(UsageError, match=r"--video needs av: .*\[video\]"):
        VideoSender(("127.0.0.1", 5600), size_px=SIZE_PX, rate_hz=RATE_HZ)
