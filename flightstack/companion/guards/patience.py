"""Wait for the pilot, no longer than the vehicle does.

A vehicle in lockstep stands still until it is answered, however long that takes. One in real time
flies on: as soon as the next image is there, or the vehicle's clock has gone on by a frame, whoever
speaks to the vehicle waits no more.
"""

from flightstack.companion.vehicle_session import VehicleSession
from flightstack.companion.waiting import Readable, wait_for_any

SLICE_S = 0.1  # wall time of one wait
FRAME_US = 50_000  # vehicle time
SILENT_S = 3.0  # wall time; without telemetry nobody knows whether the vehicle waits


class FramePatience:
    """Takes telemetry in while an image's answer is awaited."""

    def __init__(self, vehicle: VehicleSession, camera: Readable, image_us: int) -> None:
        self._vehicle, self._camera, self._image_us = vehicle, camera, image_us

    @property
    def over(self) -> bool:
        """Whether the next image is there, or would be if the camera still gave any."""
        link = self._vehicle.link
        moved_us = link.clock.stamp_us - self._image_us
        return wait_for_any(0, self._camera) or moved_us >= FRAME_US or link.silence_s > SILENT_S

    def wait(self, source: Readable) -> bool:
        """Wait until the source, telemetry or the next image is there; True for the source."""
        wait_for_any(SLICE_S, source, self._vehicle.link, self._camera)
        if wait_for_any(0, source):
            return True
        self._vehicle.receive()
        self._vehicle.keep_up(self._image_us)
        self._vehicle.link.tlog.flush_if_due()
        return False
