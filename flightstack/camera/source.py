"""What gives images, one call each."""

from typing import Protocol

from flightstack.camera.mailbox import Arrival


class CameraSource(Protocol):
    """A camera that has been opened; read in one thread, closed from any."""

    def read(self) -> Arrival:
        """Wait for the next image; raises OSError when there will be none."""

    def close(self) -> None:
        """End reading, from any thread."""
