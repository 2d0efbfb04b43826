"""Open a camera by URI or device and read it on a thread of its own."""

import contextlib
import http.client
import threading
from collections.abc import Callable
from functools import partial
from importlib.util import find_spec
from pathlib import Path

import cv2

from flightstack.camera.capture import OPEN_TIMEOUT_S, CaptureSource
from flightstack.camera.lens.rectified import RectifiedSource
from flightstack.camera.mailbox import Arrival, Mailbox
from flightstack.camera.multipart import MultipartSource, NotMultipartError
from flightstack.camera.settings import CameraSettings
from flightstack.camera.source import CameraSource
from flightstack.camera.video.video_source import SCHEMES, open_video
from flightstack.camera.video_device import is_device
from flightstack.clock import VehicleClock
from flightstack.errors import FlightstackError, LinkError, UsageError
from flightstack.printable import printable

REOPEN_S = 0.2  # wall time between attempts after a stream has broken
JOIN_S = 2.0
AS_IT_COMES = CameraSettings()
MAX_REASON = 200  # characters: a server's own words may be any number


class Camera:
    """The newest image of a source, which is opened again when it breaks; a file simply ends.

    Nothing that a source gives ends the thread that reads it: `failure` says what it last was.
    """

    def __init__(self, source: CameraSource, reopen: Callable[[], CameraSource] | None) -> None:
        self.failure: str | None = None
        self.fault: FlightstackError | None = None  # what the user alone can mend
        self.announced_hz: float | None = None  # its rate, by somebody's word
        self._source = source
        self._reopen = reopen
        self._mailbox = Mailbox()
        self._closing = threading.Event()
        self._swap = threading.Lock()  # held while the source is replaced or closed for good
        self._thread = threading.Thread(target=self._read, name="camera", daemon=True)
        self._thread.start()

    def fileno(self) -> int:
        """Return what a selector waits on: readable while there is an image."""
        return self._mailbox.fileno()

    def take(self) -> Arrival | None:
        """Take the newest image, if it has not been taken; never waits."""
        return self._mailbox.take()

    def restart(self) -> None:
        """Have the source opened again: it has stalled, and nothing else would end the read."""
        self.failure = "the camera has stalled: it is opened again"
        with self._swap:
            self._source.close()

    def close(self) -> None:
        """Stop reading."""
        with self._swap:
            self._closing.set()
            self._source.close()
        self._thread.join(JOIN_S)
        self._mailbox.close()

    def _read(self) -> None:
        while not self._closing.is_set():
            try:
                self._mailbox.put(self._source.read())
            except FlightstackError as fault:
                self.fault, self.failure = fault, printable(str(fault))
                self._let_go()
                return
            except Exception as error:  # a stranger's bytes in the hands of libraries
                if not self._closing.is_set():
                    self.failure = self.failure or f"the camera broke off: {_reason(error)}"
                if not self._resume():
                    return

    def _let_go(self) -> None:
        """Close a source that still has images: the read that fails then frees what it holds."""
        self._source.close()
        with contextlib.suppress(Exception):
            self._source.read()

    def _resume(self) -> bool:
        self._source.close()
        while self._reopen is not None and not self._closing.wait(REOPEN_S):
            with contextlib.suppress(OSError, ValueError, http.client.HTTPException, cv2.error):
                return self._replace(self._reopen())
        return False

    def _replace(self, source: CameraSource) -> bool:
        with self._swap:
            self._source = source
            if self._closing.is_set():
                source.close()
            return not self._closing.is_set()


def open_camera(
    uri: str,
    clock: VehicleClock,
    *,
    trusted: bool = True,
    timeout_s: float = OPEN_TIMEOUT_S,
    settings: CameraSettings = AS_IT_COMES,
) -> Camera:
    """Open a camera within `timeout_s`; raises LinkError where nothing can be read from it.

    Of an address that is not the user's own word (`trusted`), streams alone are read: no files, no
    playlists, nothing that could lead elsewhere.
    """
    if settings.device.asks and not (trusted and is_device(uri)):
        raise UsageError(
            f"--camera-size, --camera-rate and --camera-exposure-s: {uri} is no video device"
        )
    seen_by = partial(_rectified, settings)
    try:
        if uri.startswith(("http://", "https://")):
            open_stream = seen_by(partial(MultipartSource, uri, clock, timeout_s=timeout_s))
            with contextlib.suppress(*(NotMultipartError,) if trusted else ()):
                return Camera(open_stream(), open_stream)
        if _is_video(uri):
            open_port = seen_by(partial(open_video, uri, clock, timeout_s=timeout_s))
            return Camera(open_port(), open_port)
        open_capture = seen_by(
            partial(
                CaptureSource,
                uri,
                clock,
                trusted=trusted,
                timeout_s=timeout_s,
                device=settings.device,
            )
        )
        return Camera(open_capture(), None if Path(uri).is_file() else open_capture)
    except (OSError, ValueError, http.client.HTTPException, cv2.error) as error:
        raise LinkError(f"camera {uri} cannot be reached: {_reason(error)}") from error


def _is_video(uri: str) -> bool:
    """Whether PyAV is to read it; without PyAV, OpenCV reads all but bare RTP."""
    scheme, colon, _ = uri.partition("://")
    return bool(colon) and scheme in SCHEMES and (scheme == "rtp" or bool(find_spec("av")))


def _rectified(
    settings: CameraSettings, open_source: Callable[[], CameraSource]
) -> Callable[[], CameraSource]:
    """Have the images of a source undistorted where its lens is known."""
    if settings.view is None:
        return open_source
    view = settings.view
    return lambda: RectifiedSource(open_source(), view)


def _reason(error: Exception) -> str:
    reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
    return printable(reason[:MAX_REASON])
