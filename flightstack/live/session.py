"""Draw a vehicle while it flies: link and camera in, a growing recording out."""

import select
import time
from collections.abc import Callable

from flightstack.camera.address import check_address
from flightstack.clock import VehicleClock
from flightstack.errors import LinkError
from flightstack.live.link import LiveLink
from flightstack.live.scene.drawing import FlightDrawing
from flightstack.live.watching import CameraWatch
from flightstack.logs.columns.live import at_times

DRAW_S = 0.2  # wall time between two pieces: fewer and larger ones cost less
ASK_S = 1.0
NO_CAMERA = "none"


class LiveSession:
    """Listens until it is told to end; `tell` is for lines that the user should read."""

    def __init__(
        self,
        link: LiveLink,
        drawing: FlightDrawing,
        camera: str | None,
        tell: Callable[[str], None],
    ) -> None:
        self._link = link
        self._drawing = drawing
        self._camera = camera  # NO_CAMERA, an address, or None: what the vehicle names
        self._tell = tell
        self._watch: CameraWatch | None = None
        self._named: str | None = None  # the camera that was tried
        self._asked_s = 0.0

    def run(self, keep: Callable[[bytes], None], ends_s: float | None) -> None:
        """Draw what comes until `ends_s` of the monotonic clock, or for ever; keep the bytes."""
        try:
            while ends_s is None or time.monotonic() < ends_s:
                self._wait()
                self._turn()
                keep(self._drawing.take())
        finally:
            if self._watch is not None:
                self._watch.close()
            self._link.close()

    def _wait(self) -> None:
        time.sleep(DRAW_S)
        select.select([self._link], [], [], DRAW_S)

    def _turn(self) -> None:
        log = at_times(self._link.receive(), time.time_ns() // 1000)
        if len(log):
            self._drawing.draw(log)
        now_s = time.monotonic()
        if now_s - self._asked_s >= ASK_S:
            self._asked_s = now_s
            self._link.ask(self._drawing.track.system)
            self._open_camera()
        for image in self._watch.take() if self._watch else []:
            self._drawing.draw_image(image.stamp_us, image.rgb)

    def _open_camera(self) -> None:
        """Open the camera once it is known; one that cannot be opened is told of, once."""
        uri = self._camera or self._link.camera_uri
        if uri in (None, NO_CAMERA, self._named):
            return
        self._named = uri
        try:
            if self._camera is None:
                check_address(uri, self._link.host)
            self._watch = CameraWatch(uri, VehicleClock())
        except LinkError as error:
            self._tell(f"no images: {error}")
