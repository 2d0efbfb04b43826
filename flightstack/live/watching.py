"""Watch a camera's stream on a thread of its own, as one who only looks.

The address says `watch`: a simulator in lockstep waits for whoever answers its images, and does
not count us. Other cameras pass over what they do not know.
"""

import contextlib
import threading
from collections import deque
from http.client import HTTPException
from urllib.parse import urlsplit

from flightstack.camera.multipart import MultipartSource
from flightstack.clock import VehicleClock
from flightstack.errors import LinkError
from flightstack.records import Image

MAX_WAITING = 256  # images; the oldest give way
WATCH = "watch"


def watched(uri: str) -> str:
    """Return the address by which a stream is only looked at."""
    return uri if urlsplit(uri).query else f"{uri}?{WATCH}"


class CameraWatch:
    """Takes images as they come; nobody waits for it."""

    def __init__(self, uri: str, clock: VehicleClock) -> None:
        """Open the stream; raises LinkError."""
        try:
            self._source = MultipartSource(watched(uri), clock)
        except (OSError, ValueError, HTTPException) as error:
            raise LinkError(f"camera {uri}: {error}; name another by --camera, or none") from error
        self._waiting: deque[Image] = deque(maxlen=MAX_WAITING)
        self._thread = threading.Thread(target=self._read, name="camera", daemon=True)
        self._thread.start()

    def take(self) -> list[Image]:
        """Return the images that have come, oldest first."""
        taken = []
        with contextlib.suppress(IndexError):
            while True:
                taken.append(self._waiting.popleft())
        return taken

    def close(self) -> None:
        """End the stream."""
        self._source.close()
        self._thread.join()

    def _read(self) -> None:
        with contextlib.suppress(OSError, ValueError, HTTPException):  # the stream has ended
            while True:
                self._waiting.append(self._source.read().image)
