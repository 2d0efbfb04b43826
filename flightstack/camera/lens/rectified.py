"""Undistort the images of any source, in the thread that reads them."""

from dataclasses import replace

from flightstack.camera.lens.network_view import NetworkView
from flightstack.camera.mailbox import Arrival
from flightstack.camera.source import CameraSource


class RectifiedSource:
    """A source whose images are the network's view: a pinhole of 90 degrees, square."""

    def __init__(self, source: CameraSource, view: NetworkView) -> None:
        self._source = source
        self._view = view

    def read(self) -> Arrival:
        """Wait for the next image; raises ImageSizeError where it is not the lens's."""
        arrival = self._source.read()
        return replace(arrival, image=replace(arrival.image, rgb=self._view.of(arrival.image.rgb)))

    def close(self) -> None:
        """End reading, from any thread."""
        self._source.close()
