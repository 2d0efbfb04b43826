"""Keep the camera's images as PNG files, one per image, written on a thread of its own.

Whoever hands an image over never waits. What the disk cannot keep up with is left out, and a disk
that refuses ends the recording; `failure` says which of the two has happened. Files are named by
the image's stamp in vehicle time, 000012345678.png, and appear whole or not at all.
"""

import contextlib
import os
import threading
from pathlib import Path
from queue import SimpleQueue

import cv2

from flightstack.errors import UsageError
from flightstack.files import write_whole
from flightstack.records import Image

QUEUED_BYTES = 32 << 20  # of pixels: 2,700 of the simulator's images, 5 of a full-HD camera's
RESERVE_BYTES = 256 << 20  # of the disk: as much as one file of the log may have
CLOSE_S = 10.0  # wall time for what is still queued
FAST = (cv2.IMWRITE_PNG_COMPRESSION, 1)
NAME = "[0-9]" * 12 + ".png"


class ImageRecorder:
    """Write images into a folder; images of an earlier recording there are removed."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.failure: str | None = None
        self._put_bytes = 0  # counted by the thread that records
        self._done_bytes = 0  # counted by the thread that writes
        self._queue: SimpleQueue[Image | None] = SimpleQueue()
        try:
            folder.mkdir(parents=True, exist_ok=True)
            for earlier in folder.glob(NAME):
                earlier.unlink()
        except OSError as error:
            raise UsageError(
                f"cannot record frames in {folder}: {error.strerror}; choose another --log"
            ) from error
        self._thread = threading.Thread(target=self._write_all, name="recorder", daemon=True)
        self._thread.start()

    def record(self, image: Image) -> None:
        """Have an image written some time soon; never waits."""
        size = image.rgb.nbytes
        queued = self._put_bytes - self._done_bytes
        if queued and queued + size > QUEUED_BYTES:
            self.failure = self.failure or (
                f"the disk is too slow to record all frames: some are missing in {self.folder}"
            )
            return
        self._put_bytes += size
        self._queue.put(image)

    def close(self) -> None:
        """Wait until what is queued has been written, but not forever; leave no empty folder."""
        self._queue.put(None)
        self._thread.join(CLOSE_S)
        with contextlib.suppress(OSError):
            self.folder.rmdir()

    def _write_all(self) -> None:
        refused = False
        while (image := self._queue.get()) is not None:
            refused = refused or not self._write(image)
            self._done_bytes += image.rgb.nbytes

    def _write(self, image: Image) -> bool:
        path = self.folder / f"{image.stamp_us:012d}.png"
        _, coded = cv2.imencode(".png", cv2.cvtColor(image.rgb, cv2.COLOR_RGB2BGR), FAST)
        try:
            disk = os.statvfs(self.folder)
            if disk.f_bavail * disk.f_frsize < RESERVE_BYTES:
                left_mb = RESERVE_BYTES >> 20
                self.failure = (
                    f"the recording {self.folder} ends here: the last {left_mb} MB are the log's"
                )
                return False
            write_whole(path, coded.data)
        except OSError as error:
            self.failure = f"the recording {self.folder} ends here: {error.strerror}"
            return False
        return True
