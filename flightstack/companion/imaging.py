"""Where the loop's images come from, and where they are kept."""

from typing import Protocol

from flightstack.camera.mailbox import Arrival
from flightstack.errors import FlightstackError
from flightstack.records import Image


class ImageQueue(Protocol):
    """Where images come from, ready for a selector."""

    announced_hz: float | None  # how many a second it says that it gives
    fault: FlightstackError | None  # why none will come, where the user alone can mend it

    def fileno(self) -> int:
        """Return what a selector waits on."""

    def take(self) -> Arrival | None:
        """Take the newest image, if it has not been taken."""

    def restart(self) -> None:
        """Have the source opened again; never waits."""


class Recorder(Protocol):
    """Where images are kept."""

    def record(self, image: Image) -> None:
        """Have an image kept; never waits."""
