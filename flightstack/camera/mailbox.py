"""Hand the newest image from the camera's thread to the loop: one slot, no queue."""

import socket
import threading
from dataclasses import dataclass

from flightstack.records import Image


@dataclass(frozen=True, slots=True)
class Arrival:
    """An image, when (wall time, monotonic seconds) it was received, and whose its stamp is."""

    image: Image
    received_s: float
    stamped: bool = True  # by the camera in vehicle time; else by us, on arrival
    taken_s: float | None = None  # when the sensor took it, like received_s; None: not known
    odd_stamp: str = ""  # what it said instead of a time that a vehicle can have


class Mailbox:
    """Put in one thread, take in another; an image that was not taken in time is replaced."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._slot: Arrival | None = None
        self._is_closed = False
        self._bell_out, self._bell_in = socket.socketpair()
        for end in (self._bell_out, self._bell_in):
            end.settimeout(0.0)

    def fileno(self) -> int:
        """Return what a selector waits on: readable while there is an image."""
        return self._bell_in.fileno()

    def put(self, arrival: Arrival) -> None:
        """Leave an image, in place of any that lies there."""
        with self._lock:
            if self._is_closed:  # while the camera was delivering
                return
            rings = self._slot is None
            self._slot = arrival
            if rings:
                self._bell_out.send(b"\0")

    def take(self) -> Arrival | None:
        """Take the image, if there is one; never waits."""
        with self._lock:
            arrival, self._slot = self._slot, None
            if arrival is not None:
                self._bell_in.recv(1)
            return arrival

    def close(self) -> None:
        """Close the bell; images that are put from now on go nowhere."""
        with self._lock:
            self._is_closed = True
            self._bell_out.close()
            self._bell_in.close()
