"""Video over a network, as a camera: each picture at once, in its own time, or one clear line."""

import contextlib
import select
import socket
import sys
import threading
import time
from collections.abc import Generator, Iterator

import numpy as np
import pytest

from flightstack.arrays import Rgb
from flightstack.camera.camera import Camera, open_camera
from flightstack.camera.mailbox import Arrival
from flightstack.clock import VehicleClock
from flightstack.errors import LinkError, UsageError
from scripts.bench.between import Threaded
from sitl.process.streams.video import VideoSender
from sitl.records.images import Image
from tests.unit.flightstack.camera.video.rtsp_server import RtspServer

av = pytest.importorskip("av")
SIZE_PX, RATE_HZ = 64, 20
WAIT_S = 10.0


class CameraOnTheNet(Threaded):
    """Sends a bar that grows, over RTP, until told to end."""

    def __init__(self, port: int) -> None:
        super().__init__()
        self.sent_s: dict[int, float] = {}  # by the bar's width
        self._sender = VideoSender(("127.0.0.1", port), size_px=SIZE_PX, rate_hz=RATE_HZ)

    def _close(self) -> None:
        self._sender.close()

    def _run(self) -> None:
        began_s = time.monotonic()
        for number in range(10_000):
            if self._stop.wait(max(0.0, began_s + number / RATE_HZ - time.monotonic())):
                return
            self.sent_s[number % SIZE_PX] = time.monotonic()
            rgb = np.zeros((SIZE_PX, SIZE_PX, 3), np.uint8)
            rgb[:, : number % SIZE_PX] = (200, 40, 90)
            self._sender.publish(Image(time_us=50_000 * number, sequence=number, rgb=rgb))


def width(rgb: Rgb) -> int:
    bright = int(np.count_nonzero(rgb[rgb.shape[0] // 2, :, 0] > 100))
    return bright * SIZE_PX // int(rgb.shape[1])


def images(camera: Camera, count: int) -> Iterator[Arrival]:
    for _ in range(count):
        assert select.select([camera], [], [], WAIT_S)[0], camera.failure
        arrival = camera.take()
        assert arrival is not None
        yield arrival


@pytest.fixture
def port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        free: int = probe.getsockname()[1]
        return free


@pytest.mark.parametrize("scheme", ["udp", "rtp"])
def test_rtp_is_seen_as_soon_as_it_is_sent(port: int, scheme: str) -> None:
    with CameraOnTheNet(port) as sender:
        camera = open_camera(f"{scheme}://127.0.0.1:{port}", VehicleClock())
        late_s, off_s = [], []
        for arrival in images(camera, 30):
            sent_s = sender.sent_s[width(arrival.image.rgb)]
            assert arrival.taken_s is not None
            late_s.append(arrival.received_s - sent_s)
            off_s.append(arrival.taken_s - sent_s)
        camera.close()
    assert np.median(late_s) < 0.03  # not a period, 0.05
    assert abs(np.median(off_s)) < 0.02
    assert not arrival.stamped


def relayed(listener: socket.socket, sender: CameraOnTheNet) -> Generator[bytes, None, None]:
    """Give packets as they come, until they end."""
    with listener, contextlib.suppress(TimeoutError), sender:
        listener.settimeout(2.0)
        while True:
            yield listener.recv(2048)


def test_rtsp_is_read_in_its_own_time() -> None:
    listener = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    listener.bind(("127.0.0.1", 0))
    sender = CameraOnTheNet(listener.getsockname()[1])
    with RtspServer(relayed(listener, sender)) as server:
        camera = open_camera(server.uri, VehicleClock())
        arrivals = list(images(camera, 30))
        camera.close()
    grown = np.diff([width(arrival.image.rgb) for arrival in arrivals]) % SIZE_PX
    assert np.median(grown) == 1
    late_s = [a.received_s - sender.sent_s[width(a.image.rgb)] for a in arrivals]
    assert np.median(late_s) < 0.2  # FFmpeg waits for one further picture
    steps_s = np.diff([a.taken_s for a in arrivals if a.taken_s is not None])
    assert np.median(steps_s) == pytest.approx(1 / RATE_HZ, abs=0.005)


def test_a_transport_stream_on_a_udp_port_is_told_from_rtp(port: int) -> None:
    sending = threading.Event()

    def send() -> None:
        with av.open(f"udp://127.0.0.1:{port}?pkt_size=1316", "w", format="mpegts") as container:
            stream = container.add_stream("libx264", rate=RATE_HZ, options={"tune": "zerolatency"})
            stream.width = stream.height = SIZE_PX
            stream.pix_fmt = "yuv420p"
            stream.codec_context.gop_size = 10
            while not sending.wait(0.02):
                rgb = np.full((SIZE_PX, SIZE_PX, 3), (200, 40, 90), np.uint8)
                container.mux(stream.encode(av.VideoFrame.from_ndarray(rgb, format="rgb24")))

    thread = threading.Thread(target=send)
    thread.start()
    camera = open_camera(f"udp://127.0.0.1:{port}", VehicleClock())
    arrival = next(images(camera, 1))
    camera.close()
    sending.set()
    thread.join(5)
    assert arrival.image.rgb.shape == (SIZE_PX, SIZE_PX, 3)
    assert np.abs(arrival.image.rgb.mean(axis=(0, 1)) - (200, 40, 90)).max() < 12


def test_a_port_where_nothing_comes_is_told(port: int) -> None:
    with pytest.raises(LinkError, match=f"nothing arrives at UDP port {port}"):
        open_camera(f"udp://127.0.0.1:{port}", VehicleClock(), timeout_s=0.1)
    with pytest.raises(LinkError, match="name the port"):
        open_camera("rtp://127.0.0.1", VehicleClock(), timeout_s=0.1)


def test_without_pyav_bare_rtp_says_what_to_install(
    port: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    with CameraOnTheNet(port):
        monkeypatch.setitem(sys.modules, "av", None)
        with pytest.raises(UsageError, match=r"needs av: .*\[video\]"):
            open_camera(f"rtp://127.0.0.1:{port}", VehicleClock())
