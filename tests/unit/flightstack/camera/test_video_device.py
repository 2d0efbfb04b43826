"""A video device gets what was asked for, by a fake one: no test has a camera."""

from typing import Any, ClassVar

import cv2
import numpy as np
import pytest

from flightstack.arrays import Rgb
from flightstack.camera.camera import open_camera
from flightstack.camera.capture import CaptureSource
from flightstack.camera.settings import CameraSettings, DeviceSettings
from flightstack.clock import VehicleClock
from flightstack.errors import UsageError

WIDTH, HEIGHT, RATE = cv2.CAP_PROP_FRAME_WIDTH, cv2.CAP_PROP_FRAME_HEIGHT, cv2.CAP_PROP_FPS
RAW, COMPRESSED = {(640, 480): 30.0, (1280, 720): 10.0}, {(1280, 720): 30.0, (1920, 1080): 30.0}
NOW_S = 1000.0


class FakeDevice:
    """A USB camera: large images come quickly when compressed; it takes the nearest that it has."""

    opened: ClassVar[list["FakeDevice"]] = []
    stamp_ms = 1e3 * (NOW_S - 0.021)

    def __init__(self, where: object, backend: int = 0) -> None:
        self.where, self.backend = where, backend
        self.asked: dict[int, float] = {WIDTH: 640, HEIGHT: 480, RATE: 30.0}
        self.released = False
        FakeDevice.opened.append(self)

    def isOpened(self) -> bool:  # noqa: N802  (OpenCV's name)
        return True

    def set(self, prop: int, value: float) -> bool:
        self.asked[prop] = value
        return True

    def get(self, prop: int) -> float:
        if prop == cv2.CAP_PROP_POS_MSEC:
            return self.stamp_ms
        if prop == cv2.CAP_PROP_EXPOSURE:
            return min(self.asked.get(prop, 100.0), 300.0)
        size, rate = self._mode()
        return {WIDTH: size[0], HEIGHT: size[1], RATE: rate}.get(prop, 0.0)

    def read(self) -> tuple[bool, Rgb]:
        return True, np.zeros((480, 640, 3), np.uint8)

    def release(self) -> None:
        self.released = True

    def _mode(self) -> tuple[tuple[int, int], float]:
        modes = COMPRESSED if self.asked.get(cv2.CAP_PROP_FOURCC) else RAW
        size = min(modes, key=lambda size: abs(size[0] - self.asked[WIDTH]))
        return size, min(modes[size], self.asked[RATE])


@pytest.fixture(autouse=True)
def device(monkeypatch: pytest.MonkeyPatch) -> None:
    FakeDevice.opened.clear()
    monkeypatch.setattr(cv2, "VideoCapture", FakeDevice)


def opened(uri: str = "0", **settings: Any) -> FakeDevice:
    wanted = DeviceSettings(**settings)
    CaptureSource(uri, VehicleClock(lambda: NOW_S), device=wanted)
    return FakeDevice.opened[-1]


def test_size_rate_and_exposure_are_set() -> None:
    device = opened("/dev/video2", size_px=(640, 480), rate_hz=30.0, exposure_s=0.005)
    assert (device.where, device.backend) == ("/dev/video2", cv2.CAP_V4L2)
    assert device.asked[cv2.CAP_PROP_AUTO_EXPOSURE] == 1
    assert device.asked[cv2.CAP_PROP_EXPOSURE] == 50  # of 100 us
    assert device.asked[cv2.CAP_PROP_BUFFERSIZE] == 1
    assert cv2.CAP_PROP_FOURCC not in device.asked


def test_what_is_left_out_stays_as_it_is() -> None:
    device = opened()
    assert device.asked == {WIDTH: 640, HEIGHT: 480, RATE: 30.0}


def test_images_are_compressed_where_the_rate_needs_it() -> None:
    device = opened(size_px=(1280, 720), rate_hz=30.0)
    assert device.asked[cv2.CAP_PROP_FOURCC] == cv2.VideoWriter.fourcc(*"MJPG")


@pytest.mark.parametrize(
    ("settings", "why"),
    [
        ({"size_px": (800, 600)}, "gives 1280 x 720 at 30 images a second, not what --camera-size"),
        ({"rate_hz": 90.0}, "gives 1280 x 720 at 30 images a second"),
        ({"exposure_s": 0.1}, "exposes for 30 ms, not for the 100 of --camera-exposure-s"),
    ],
)
def test_what_it_cannot_do_is_told(settings: dict[str, Any], why: str) -> None:
    with pytest.raises(UsageError, match=why):
        opened(**settings)
    assert FakeDevice.opened[-1].released


def test_images_are_dated_by_the_driver(monkeypatch: pytest.MonkeyPatch) -> None:
    clock = VehicleClock(lambda: NOW_S)
    clock.observe(8_000_000)
    source = CaptureSource("0", clock)
    arrival = source.read()
    assert arrival.taken_s == pytest.approx(NOW_S - 0.021)
    assert arrival.image.stamp_us == pytest.approx(7_979_000, abs=1)
    for told_ms in (0.0, 1e3 * (NOW_S + 5.0), 1.7e12):  # no time, or one since 1970
        monkeypatch.setattr(FakeDevice, "stamp_ms", told_ms)
        assert source.read().taken_s is None


@pytest.mark.parametrize("uri", ["flight.mp4", "http://127.0.0.1:1/", "rtsp://127.0.0.1:1/x"])
def test_an_address_takes_no_settings_of_a_device(uri: str) -> None:
    settings = CameraSettings(device=DeviceSettings(rate_hz=30.0))
    with pytest.raises(UsageError, match=f"{uri} is no video device"):
        open_camera(uri, VehicleClock(), settings=settings)
