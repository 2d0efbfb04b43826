"""Whatever a camera's server sends: the thread lives, memory stays, nothing waits for ever."""

import resource
import socket
import struct
import threading
import time
import zlib
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import pytest

from flightstack.camera.camera import open_camera
from flightstack.camera.capture import STREAMS_ONLY, CaptureSource
from flightstack.camera.multipart import MultipartSource
from flightstack.camera.parts import decode_rgb
from flightstack.camera.picture_size import MAX_PIXELS, picture_size
from flightstack.clock import VehicleClock
from flightstack.errors import LinkError
from tests.unit.flightstack.camera.made_stream import MadeStream, part, picture
from tests.unit.flightstack.camera.test_camera import next_image

GOOD = part(picture(1, 2, 3), X_Timestamp="3.5")


def chunk(kind: bytes, data: bytes, length: int | None = None) -> bytes:
    checksum = struct.pack(">I", zlib.crc32(kind + data))
    return struct.pack(">I", len(data) if length is None else length) + kind + data + checksum


def png(width: int, height: int) -> bytes:
    """A PNG of the size that its header says, and of hardly any data: 98 bytes or so."""
    header = chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0))
    data = chunk(b"IDAT", zlib.compress(bytes(100)))
    return b"\x89PNG\r\n\x1a\n" + header + data + chunk(b"IEND", b"")


def jpeg(width: int, height: int) -> bytes:
    """A JPEG whose header says another size than its data have."""
    content = bytearray(cv2.imencode(".jpg", picture(1, 2, 3))[1].tobytes())
    at = content.index(b"\xff\xc0")
    struct.pack_into(">HH", content, at + 5, height, width)
    return bytes(content)


def raw_part(content: bytes, stamp: str = "1.0") -> bytes:
    head = f"--b\r\nX-Timestamp: {stamp}\r\nContent-Length: {len(content)}\r\n\r\n"
    return head.encode() + content + b"\r\n"


def with_chunk(piece: bytes) -> bytes:
    """A sound PNG with something before its end."""
    content = cv2.imencode(".png", picture(1, 2, 3))[1].tobytes()
    return content[:-12] + piece + content[-12:]


HUGE = {
    "a chunk of 4 GB": with_chunk(chunk(b"tEXt", b"x" * 50, length=0xFAFFFFD2)),
    "an end that is none": png(8, 8)[:33] + chunk(b"IEND", b"\xff" * 40, length=20),
    "more behind the end": png(8, 8)[:33] + chunk(b"IEND", b"") + b"\xff" * 40,
    "a second header": with_chunk(png(100_000, 100_000)[8:33]),
    "an animation": with_chunk(chunk(b"acTL", struct.pack(">II", 2, 0))),
    "half a png": cv2.imencode(".png", picture(1, 2, 3))[1].tobytes()[:-20],
    "1000 scans": cv2.imencode(".jpg", picture(1, 2, 3))[1].tobytes() + b"\xff\xda" * 1000,
    "png": png(100_000, 100_000),
    "png that just fits a line": png(2**31 - 1, 1),
    "a png of 1 MB": png(20_000, 20_000) + bytes(1 << 20),
    "jpeg": jpeg(65_500, 65_500),
    "ppm": b"P6 99999 99999 255\n" + bytes(100),
    "bmp": b"BM" + struct.pack("<IHHIIiiHHIIiiII", 99, 0, 0, 54, 40, 99999, 99999, 1, 24, *[0] * 6),
    "gif": b"GIF89a" + struct.pack("<HHBBB", 65535, 65535, 0, 0, 0),
    "hdr": b"#?RADIANCE\n\n-Y 99999 +X 99999\n",
    "pfm": b"PF\n99999 99999\n-1.0\n",
    "nothing": png(0, 0),
}


@pytest.mark.parametrize("content", HUGE.values(), ids=HUGE.keys())
def test_a_picture_of_a_size_that_nobody_means_is_refused_before_it_is_decoded(
    content: bytes,
) -> None:
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert decode_rgb(content) is None
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 20_000  # kB


@pytest.mark.parametrize("suffix", [".png", ".jpg"])
def test_sizes_are_read_as_the_decoder_reads_them(suffix: str) -> None:
    rgb = np.zeros((37, 91, 3), np.uint8)
    content = cv2.imencode(suffix, rgb)[1].tobytes()
    assert picture_size(content) == (37, 91)
    decoded = decode_rgb(content)
    assert decoded is not None
    assert decoded.shape == rgb.shape
    assert MAX_PIXELS >= 3840 * 2160


def test_images_go_on_after_any_bad_one() -> None:
    bad = b"".join(map(raw_part, HUGE.values()))
    with MadeStream(bad + GOOD) as stream:
        source = MultipartSource(stream.uri, VehicleClock())
        assert source.read().image.stamp_us == 3_500_000
        source.close()


@pytest.mark.parametrize(
    "stamp", ["-1", "-0.1", "1e20", "inf", "-inf", "nan", "1733050000.123", "x", "", "9" * 4000]
)
def test_a_stamp_that_no_vehicle_has_is_replaced_by_the_time_of_arrival(stamp: str) -> None:
    clock = VehicleClock(lambda: 0.0)
    clock.observe(5_000_000)
    with MadeStream(part(picture(1, 2, 3), X_Timestamp=stamp, X_Sequence="9" * 50)) as stream:
        source = MultipartSource(stream.uri, clock)
        arrival = source.read()
        source.close()
    assert (arrival.image.stamp_us, arrival.image.sequence) == (5_000_000, 1)
    assert (arrival.stamped, arrival.odd_stamp) == (False, stamp)


@pytest.mark.parametrize(
    "garbage",
    [
        b"--b\r\nContent-Length: x\r\n\r\n",
        b"--b\r\nContent-Length: -5\r\n\r\n",
        b"--b\r\nContent-Length: 99999999999999999999\r\n\r\n",
        b"X: y\r\n" * 1000,
        bytes(100_000),
        b"\xff" * 100_000,
    ],
    ids=["letters", "negative", "endless", "headers", "zeros", "ones"],
)
def test_a_stream_of_garbage_is_opened_again(garbage: bytes) -> None:
    with MadeStream(GOOD + garbage, ends=True) as stream:
        camera = open_camera(stream.uri, VehicleClock())
        for _ in range(2):
            next_image(camera)
        assert camera.failure is not None
        assert camera.failure.startswith("the camera broke off: ")
        camera.close()


def test_a_stream_that_stalls_is_opened_again_when_asked_to() -> None:
    with MadeStream(GOOD) as stream:
        camera = open_camera(stream.uri, VehicleClock())
        next_image(camera)
        camera.restart()
        next_image(camera)
        camera.close()
    assert len(stream.requests) == 2


@pytest.fixture
def dripping() -> Iterator[str]:
    """A server whose headers never end, byte by byte."""
    server = socket.create_server(("127.0.0.1", 0))

    def drip() -> None:
        try:
            client, _ = server.accept()
            with client:
                client.sendall(b"HTTP/1.1 200 OK\r\nX: ")
                while client.send(b"x"):
                    time.sleep(0.02)
        except OSError:
            return

    thread = threading.Thread(target=drip, daemon=True)
    thread.start()
    yield f"http://127.0.0.1:{server.getsockname()[1]}/"
    server.close()
    thread.join(5)


def test_headers_that_drip_in_are_given_up(dripping: str) -> None:
    began_s = time.monotonic()
    with pytest.raises(LinkError, match="answers too slowly"):
        open_camera(dripping, VehicleClock(), timeout_s=0.3)
    assert time.monotonic() - began_s < 3.0


def test_what_a_vehicle_names_must_be_a_stream() -> None:
    greeting = b"HTTP/1.1 200 OK\r\nContent-Type: application/x-mpegurl\r\n\r\n"
    playlist = b"#EXTM3U\n#EXTINF:1,\nfile:///etc/passwd\n"
    with (
        MadeStream(playlist, greeting=greeting, ends=True) as stream,
        pytest.raises(LinkError, match="mpegurl"),
    ):
        open_camera(stream.uri, VehicleClock(), trusted=False)


def test_no_file_is_read_of_what_a_vehicle_names(tmp_path: Path) -> None:
    video = tmp_path / "secret.avi"
    writer = cv2.VideoWriter(str(video), cv2.VideoWriter.fourcc(*"MJPG"), 20.0, (64, 64))
    writer.write(picture(1, 2, 3))
    writer.release()
    CaptureSource(str(video), VehicleClock())
    for uri in (str(video), f"concat:{video}", f"file:{video}", f"file://{video}"):
        with pytest.raises(OSError, match="OpenCV cannot open it"):
            CaptureSource(uri, VehicleClock(), trusted=False)
    assert "file" not in STREAMS_ONLY
