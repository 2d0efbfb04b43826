"""Keep the camera's frames as PNG files, one a frame, written on a thread of its own.

Whoever hands a frame over never waits. What the disk cannot keep up with is left out, and a disk
that refuses ends the recording; `failure` says which of the two has happened. Files are named by
the frame's stamp in vehicle time, 000012345678.png, and appear whole or not at all.
"""

import contextlib
import threading
from pathlib import Path
from queue import SimpleQueue

import cv2

from flightstack.errors import UsageError
from flightstack.files import write_whole
from flightstack.records import Frame

QUEUED_BYTES = 32 << 20  # of pixels: 2,700 of the simulator's frames, 5 of a full-HD camera's
CLOSE_S = 10.0  # wall time for what is still queued
FAST = (cv2.IMWRITE_PNG_COMPRESSION, 1)
NAME = "[0-9]" * 12 + ".png"


class FrameRecorder:
    """Write frames into a folder; frames of an earlier recording there are removed."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.failure: str | None = None
        self._put_bytes = 0  # counted by the thread that records
        self._done_bytes = 0  # counted by the thread that writes
        self._queue: SimpleQueue[Frame | None] = SimpleQueue()
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

    def record(self, frame: Frame) -> None:
        """Have a frame written some time soon; never waits."""
        size = frame.rgb.nbytes
        queued = self._put_bytes - self._done_bytes
        if queued and queued + size > QUEUED_BYTES:
            self.failure = self.failure or (
                f"the disk is too slow to record all frames: some are missing in {self.folder}"
            )
            return
        self._put_bytes += size
        self._queue.put(frame)

    def close(self) -> None:
        """Wait until what is queued has been written, but not forever; leave no empty folder."""
        self._queue.put(None)
        self._thread.join(CLOSE_S)
        with contextlib.suppress(OSError):
            self.folder.rmdir()

    def _write_all(self) -> None:
        refused = False
        while (frame := self._queue.get()) is not None:
            refused = refused or not self._write(frame)
            self._done_bytes += frame.rgb.nbytes

    def _write(self, frame: Frame) -> bool:
        path = self.folder / f"{frame.stamp_us:012d}.png"
        _, coded = cv2.imencode(".png", cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2BGR), FAST)
        try:
            write_whole(path, coded.data)
        except OSError as error:
            self.failure = f"the recording {self.folder} ends here: {error.strerror}"
            return False
        return True
