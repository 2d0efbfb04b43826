"""The camera stream over real sockets, driven by hand."""

import contextlib
import socket
from collections.abc import Iterator

import numpy as np
import pytest

from sitl.errors import LinkError
from sitl.process.streams.camera_stream import MAX_CLIENTS, CameraStream
from sitl.process.streams.http_stream import MAX_REQUEST_BYTES
from sitl.records.images import Image
from tests.pictures import decoded

GET_STREAM = b"GET /stream HTTP/1.1\r\nHost: localhost\r\n\r\n"


def make_image(sequence: int, size: int = 64) -> Image:
    rgb = np.random.default_rng(sequence).integers(0, 256, (size, size, 3), dtype=np.uint8)
    return Image(time_us=sequence * 52_000, sequence=sequence, rgb=rgb)


class Viewer:
    """A client that reads what is there."""

    def __init__(self, stream: CameraStream, request: bytes = GET_STREAM) -> None:
        self.socket = socket.create_connection(("127.0.0.1", stream.port), timeout=2.0)
        self.stream = stream
        self.data = b""
        stream.serve(1.0)
        if request:
            self.socket.sendall(request)
            stream.serve(1.0)

    def read_until(self, ending: bytes) -> bytes:
        while ending not in self.data:
            received = self.socket.recv(65536)
            assert received, f"closed before {ending!r}"
            self.data += received
        piece, self.data = self.data.split(ending, 1)
        return piece

    def read_part(self) -> tuple[dict[str, str], bytes]:
        lines = self.read_until(b"\r\n\r\n").decode().strip().split("\r\n")
        headers = dict(line.split(": ", 1) for line in lines)
        length = int(headers["Content-Length"])
        while len(self.data) < length:
            self.data += self.socket.recv(65536)
        image, self.data = self.data[:length], self.data[length:]
        self.read_until(b"\r\n--frame\r\n")
        return headers, image

    def read_head(self) -> bytes:
        head = self.read_until(b"\r\n\r\n")
        if b"multipart" in head:
            self.read_until(b"--frame\r\n")
        return head


@pytest.fixture
def stream() -> Iterator[CameraStream]:
    stream = CameraStream(0)
    yield stream
    stream.close()


def test_parts_are_stamped_and_lossless(stream: CameraStream) -> None:
    viewer = Viewer(stream)
    assert b"multipart/x-mixed-replace; boundary=frame" in viewer.read_head()
    for sequence in (0, 1, 25):
        image = make_image(sequence)
        stream.publish(image)
        headers, data = viewer.read_part()
        assert headers["Content-Type"] == "image/png"
        assert headers["X-Sequence"] == str(sequence)
        assert headers["X-Timestamp"] == f"{sequence * 0.052:.6f}"
        bgr = decoded(data)
        assert np.array_equal(bgr[:, :, ::-1], image.rgb)
    viewer.socket.close()


def test_a_new_viewer_gets_the_latest_image_at_once(stream: CameraStream) -> None:
    stream.publish(make_image(0))
    stream.publish(make_image(7))
    viewer = Viewer(stream)
    viewer.read_head()
    assert viewer.read_part()[0]["X-Sequence"] == "7"
    viewer.socket.close()


def test_jpeg_for_those_who_ask(stream: CameraStream) -> None:
    viewer = Viewer(stream, GET_STREAM.replace(b"/stream", b"/stream.mjpg?x=1"))
    viewer.read_head()
    stream.publish(make_image(0))
    headers, data = viewer.read_part()
    assert headers["Content-Type"] == "image/jpeg"
    assert decoded(data).shape == (64, 64, 3)
    viewer.socket.close()


def test_who_only_watches_gets_all_images_and_is_waited_for_by_nobody(
    stream: CameraStream,
) -> None:
    watcher = Viewer(stream, b"GET /stream?watch HTTP/1.1\r\n\r\n")
    assert not stream.has_viewers
    watcher.read_head()
    stream.publish(make_image(0))
    headers, _ = watcher.read_part()
    assert headers["Content-Type"] == "image/png"
    viewer = Viewer(stream)
    assert stream.has_viewers
    viewer.socket.close()
    stream.serve(1.0)
    assert not stream.has_viewers
    watcher.socket.close()


def test_only_streams_make_viewers(stream: CameraStream) -> None:
    page = Viewer(stream, b"GET / HTTP/1.0\r\n\r\n")
    head = page.read_head()
    assert head.startswith(b"HTTP/1.1 200 OK")
    assert b"text/html" in head
    assert b"/stream.mjpg" in page.read_until(b"</html>")
    assert not stream.has_viewers
    viewer = Viewer(stream)
    assert stream.has_viewers
    viewer.socket.close()
    stream.serve(1.0)
    assert not stream.has_viewers
    page.socket.close()


@pytest.mark.parametrize(
    ("request_", "status"),
    [
        (b"GET /nothing HTTP/1.1\r\n\r\n", b"404"),
        (b"POST /stream HTTP/1.1\r\n\r\n", b"405"),
        (b"\r\n\r\n", b"405"),
        (b"\xff\xfe\x00 \xff\r\n\r\n", b"405"),
        (b"GET\r\n\r\n", b"404"),
    ],
)
def test_other_requests_are_answered_and_closed(
    stream: CameraStream, request_: bytes, status: bytes
) -> None:
    viewer = Viewer(stream, request_)
    assert viewer.read_head().split()[1] == status
    while viewer.socket.recv(4096):
        pass
    assert not stream.has_viewers
    viewer.socket.close()


def test_a_request_in_pieces_is_understood(stream: CameraStream) -> None:
    viewer = Viewer(stream, GET_STREAM[:10])
    assert not stream.has_viewers
    viewer.socket.sendall(GET_STREAM[10:])
    stream.serve(1.0)
    assert stream.has_viewers
    viewer.socket.close()


def test_an_endless_request_is_cut_off(stream: CameraStream) -> None:
    viewer = Viewer(stream, b"")
    viewer.socket.sendall(b"G" * (MAX_REQUEST_BYTES + 4096))
    for _ in range(10):
        stream.serve(0.01)
    with contextlib.suppress(ConnectionResetError):  # closed with something unread
        assert viewer.socket.recv(1) == b""
    viewer.socket.close()


def test_a_slow_viewer_skips_images_and_holds_nobody_up(stream: CameraStream) -> None:
    slow = socket.socket()
    slow.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    slow.connect(("127.0.0.1", stream.port))
    stream.serve(1.0)
    slow.sendall(GET_STREAM)
    stream.serve(1.0)
    last = 60
    for sequence in range(last + 1):
        stream.publish(make_image(sequence, size=512))  # 0.8 MB each
    viewer = Viewer.__new__(Viewer)
    viewer.socket, viewer.stream, viewer.data = slow, stream, b""
    slow.settimeout(0.0)
    while f"X-Sequence: {last}".encode() not in viewer.data:
        stream.serve(0.0)
        try:
            viewer.data += slow.recv(1 << 20)
        except BlockingIOError:
            stream.serve(0.01)
    got = viewer.data.count(b"X-Sequence")
    assert 2 <= got < last // 2
    slow.close()


def test_too_many_connections_push_out_those_that_ask_for_nothing(stream: CameraStream) -> None:
    viewer = Viewer(stream)
    idle = []
    for _ in range(2 * MAX_CLIENTS):
        idle.append(socket.create_connection(("127.0.0.1", stream.port)))
        stream.serve(1.0)
    assert stream.has_viewers
    assert len(stream._clients) <= MAX_CLIENTS
    late = Viewer(stream)
    late.read_head()
    for connection in (*idle, viewer.socket, late.socket):
        connection.close()


def test_a_busy_port_is_refused_with_the_remedy(stream: CameraStream) -> None:
    with pytest.raises(LinkError, match=f"{stream.port} is in use.*--camera-port"):
        CameraStream(stream.port)


def test_the_uri_is_where_the_lossless_stream_is(stream: CameraStream) -> None:
    assert stream.uri == f"http://127.0.0.1:{stream.port}/stream"
