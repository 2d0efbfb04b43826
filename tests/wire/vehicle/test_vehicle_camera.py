"""The camera as a client finds and sees it."""

import itertools
from collections.abc import Iterator
from typing import Any

import cv2
import pytest

from tests.pictures import decoded
from tests.wire.stream_viewer import StreamViewer
from tests.wire.vehicle_process import Vehicle, is_acknowledgement

pytestmark = pytest.mark.flight
CAMERA = 100
IMAGE_GAPS_US = {48_000, 52_000}  # 20 Hz on 4 ms ticks


@pytest.fixture(scope="module")
def vehicle() -> Iterator[Vehicle]:
    with Vehicle("-q") as vehicle:
        vehicle.wait_until_up()
        yield vehicle


@pytest.fixture(scope="module")
def uri(vehicle: Vehicle) -> str:
    """Discover the stream as a companion does."""
    vehicle.api.command(512, 259, target=(1, CAMERA))
    information = vehicle.api.wait_for("CAMERA_INFORMATION")
    assert information.flags & 256  # it has a video stream
    vehicle.api.command(512, 269, target=(1, CAMERA))
    stream = vehicle.api.wait_for("VIDEO_STREAM_INFORMATION")
    assert vehicle.api.wait_for(is_acknowledgement(512)).result == 0
    assert (stream.resolution_h, stream.resolution_v, stream.hfov) == (64, 64, 90)
    return str(stream.uri)


def test_images_are_lossless_stamped_and_regular(uri: str) -> None:
    with StreamViewer(uri) as viewer:
        parts = [viewer.read() for _ in range(12)]
    gaps = {b.time_us - a.time_us for a, b in itertools.pairwise(parts)}
    assert gaps <= IMAGE_GAPS_US
    assert [part.sequence for part in parts] == list(
        range(parts[0].sequence, parts[0].sequence + 12)
    )
    for part in parts:
        assert part.content_type == "image/png"
        image = decoded(part.data)
        assert image.shape == (64, 64, 3)
        assert image.std() > 5.0  # it sees something


def test_each_image_was_announced_with_its_own_stamp(vehicle: Vehicle, uri: str) -> None:
    vehicle.api.forget()
    with StreamViewer(uri) as viewer:
        stamps = {part.time_us: part.sequence for part in (viewer.read() for _ in range(10))}
    triggers: dict[int, Any] = {}
    while not set(stamps) - set(list(stamps)[:1]) <= set(triggers):
        trigger = vehicle.api.wait_for("CAMERA_TRIGGER")
        assert trigger.get_srcComponent() == CAMERA
        triggers[trigger.time_usec] = trigger.seq
    later = {stamp: sequence for stamp, sequence in stamps.items() if stamp in triggers}
    assert later == {stamp: triggers[stamp] for stamp in later}


def test_opencv_opens_the_jpeg_stream(uri: str) -> None:
    capture = cv2.VideoCapture(uri + ".mjpg")
    assert capture.isOpened()
    shapes = set()
    for _ in range(5):
        arrived, image = capture.read()
        assert arrived
        shapes.add(image.shape)
    capture.release()
    assert shapes == {(64, 64, 3)}
