"""Any camera by one call: streams, files, and clear words for what is none."""

import select
import socket
from pathlib import Path

import cv2
import numpy as np
import pytest

from flightstack.camera.camera import Camera, open_camera
from flightstack.camera.lens.network_view import ImageSizeError, NetworkView
from flightstack.camera.mailbox import Arrival
from flightstack.camera.settings import CameraSettings
from flightstack.clock import VehicleClock
from flightstack.errors import LinkError
from tests.lenses import STRONG
from tests.unit.flightstack.camera.made_stream import MadeStream, part, picture

WAIT_S = 10.0


def next_image(camera: Camera) -> Arrival:
    assert select.select([camera], [], [], WAIT_S)[0]
    arrival = camera.take()
    assert arrival is not None
    return arrival


@pytest.fixture
def video(tmp_path: Path) -> Path:
    path = tmp_path / "flight.avi"
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 50.0, (64, 64))
    for _ in range(5):
        writer.write(np.full((64, 64, 3), (0, 0, 255), np.uint8))  # BGR
    writer.release()
    return path


def test_reads_a_stamped_stream() -> None:
    with MadeStream(part(picture(1, 2, 3), X_Timestamp="3.5")) as stream:
        camera = open_camera(stream.uri, VehicleClock())
        arrival = next_image(camera)
        assert (arrival.image.stamp_us, arrival.stamped) == (3_500_000, True)
        camera.close()


def test_images_of_another_shape_than_was_calibrated_are_the_users_fault() -> None:
    with MadeStream(part(picture(1, 2, 3), X_Timestamp="3.5")) as stream:
        camera = open_camera(
            stream.uri, VehicleClock(), settings=CameraSettings(view=NetworkView(STRONG))
        )
        camera._thread.join(WAIT_S)
        assert isinstance(camera.fault, ImageSizeError)
        assert camera.failure == str(camera.fault)
        camera.close()


def test_opens_a_stream_again_that_ended() -> None:
    with MadeStream(part(picture(1, 2, 3), X_Timestamp="3.5"), ends=True) as stream:
        camera = open_camera(stream.uri, VehicleClock())
        for _ in range(3):
            next_image(camera)
        camera.close()
        assert len(stream.requests) >= 3


def test_plays_a_video_file_in_vehicle_time(video: Path) -> None:
    clock = VehicleClock(lambda: 0.0)
    clock.observe(8_000_000)
    camera = open_camera(str(video), clock)
    arrival = next_image(camera)
    assert (arrival.image.stamp_us, arrival.stamped) == (8_000_000, False)
    assert arrival.image.rgb[30, 30, 0] > 240
    camera.close()


@pytest.mark.parametrize(
    "uri", ["/dev/nosuchvideo", "97", "nosuch.avi", "rtsp://127.0.0.1:1/x", "http://127.0.0.1:1/x"]
)
def test_what_cannot_be_opened_is_one_clear_line(
    uri: str, capfd: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(LinkError) as refusal:
        open_camera(uri, VehicleClock())
    assert str(refusal.value).startswith(f"camera {uri} cannot be reached: ")
    assert "\n" not in str(refusal.value)
    assert capfd.readouterr() == ("", "")


def test_a_server_that_speaks_no_http_is_no_camera() -> None:
    with (
        MadeStream(greeting=b"SSH-2.0-OpenSSH\r\n", ends=True) as stream,
        pytest.raises(LinkError, match="cannot be reached"),
    ):
        open_camera(stream.uri, VehicleClock())


def test_closing_ends_a_read_that_waits() -> None:
    with MadeStream() as stream:
        camera = open_camera(stream.uri, VehicleClock())
        camera.close()
    with pytest.raises((OSError, ValueError)):
        select.select([camera], [], [], 0)


def test_a_port_in_the_uri_may_be_wrong() -> None:
    with socket.socket() as unheard:
        unheard.bind(("127.0.0.1", 0))
        with pytest.raises(LinkError):
            open_camera(f"http://127.0.0.1:{unheard.getsockname()[1]}/", VehicleClock())
    with pytest.raises(LinkError, match="ort"):
        open_camera("http://127.0.0.1:many/", VehicleClock())
