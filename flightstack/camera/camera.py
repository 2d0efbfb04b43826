"""Open a camera by URI or device and read it on a thread of its own."""

import contextlib
import http.client
import threading
from collections.abc import Callable
from functools import partial
from typing import Protocol

from flightstack.camera.capture import CaptureSource
from flightstack.camera.mailbox import Arrival, Mailbox
from flightstack.camera.multipart import MultipartSource, NotMultipartError
from flightstack.clock import VehicleClock
from flightstack.errors import LinkError

REOPEN_S = 0.2  # wall time between attempts after a stream has broken
JOIN_S = 2.0


class CameraSource(Protocol):
    """Something that gives images, one call each."""

    stamped: bool  # whether the images carry the vehicle's own stamps

    def read(self) -> Arrival:
        """Wait for the next image; raises OSError when there will be none."""

    def close(self) -> None:
        """End reading, from any thread."""


class Camera:
    """The newest image of a source; reopens a network stream that breaks."""

    def __init__(self, source: CameraSource, reopen: Callable[[], CameraSource] | None) -> None:
        self._source = source
        self._reopen = reopen
        self._mailbox = Mailbox()
        self._closing = threading.Event()
        self._swap = threading.Lock()  # held while the source is replaced or closed for good
        self._thread = threading.Thread(target=self._read, name="camera", daemon=True)
        self._thread.start()

    @property
    def stamped(self) -> bool:
        """Whether images carry the vehicle's own stamps; known after the first."""
        return self._source.stamped

    def fileno(self) -> int:
        """Return what a selector waits on: readable while there is an image."""
        return self._mailbox.fileno()

    def take(self) -> Arrival | None:
        """Take the newest image, if it has not been taken; never waits."""
        return self._mailbox.take()

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
            except (OSError, ValueError, http.client.HTTPException):  # ended, or no longer a stream
                if not self._resume():
                    return

    def _resume(self) -> bool:
        self._source.close()
        while self._reopen is not None and not self._closing.wait(REOPEN_S):
            with contextlib.suppress(OSError, http.client.HTTPException):
                return self._replace(self._reopen())
        return False

    def _replace(self, source: CameraSource) -> bool:
        with self._swap:
            self._source = source
            if self._closing.is_set():
                source.close()
            return not self._closing.is_set()


def open_camera(uri: str, clock: VehicleClock) -> Camera:
    """Open a camera; raises LinkError where nothing can be read from it."""
    try:
        if uri.startswith(("http://", "https://")):
            open_stream = partial(MultipartSource, uri, clock)
            with contextlib.suppress(NotMultipartError):
                return Camera(open_stream(), open_stream)
        return Camera(CaptureSource(uri, clock), None)
    except (OSError, ValueError, http.client.HTTPException) as error:
        reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
        raise LinkError(f"camera {uri} cannot be reached: {reason}") from error
