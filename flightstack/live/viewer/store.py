"""Keep a recording's bytes for whoever looks, from its start, while it grows."""

import threading
from collections.abc import Iterator

MAX_BYTES = 1 << 30  # some two hours of the simulator


class RecordingStore:
    """Bytes that only grow; written by one thread, read by any."""

    def __init__(self) -> None:
        self._pieces: list[bytes] = []
        self._size = 0
        self._ended = False
        self._changed = threading.Condition()

    @property
    def is_full(self) -> bool:
        """Whether no more is kept."""
        return self._size >= MAX_BYTES

    def add(self, piece: bytes) -> None:
        """Keep a piece, and hand it to all who read; one beyond the limit is left out."""
        if piece and not self.is_full:
            with self._changed:
                self._pieces.append(piece)
                self._size += len(piece)
                self._changed.notify_all()

    def end(self) -> None:
        """Say that no more will come."""
        with self._changed:
            self._ended = True
            self._changed.notify_all()

    def read(self) -> bytes:
        """Return all that there is."""
        with self._changed:
            return b"".join(self._pieces)

    def follow(self) -> Iterator[bytes]:
        """Yield all pieces, and those to come until the end."""
        place, ended = 0, False
        while not ended:
            found, ended = self._after(place)
            place += len(found)
            yield from found

    def _after(self, place: int) -> tuple[list[bytes], bool]:
        """Wait for pieces after the first `place`; return them, and whether they are the last."""
        with self._changed:
            self._changed.wait_for(lambda: self._ended or place < len(self._pieces))
            return self._pieces[place:], self._ended
