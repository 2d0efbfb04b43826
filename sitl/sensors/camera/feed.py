"""The camera as the vehicle has it: when it takes an image, and when it gives one out.

20 times a second, unless it fails, it takes an image and spoils it as the conditions say. A late
camera gives each image out some time after, with the stamp of the moment at which it was taken.
"""

import numpy as np

from sitl.clock import SECOND_US, Schedule
from sitl.records.conditions import CameraFaults
from sitl.records.failures import DELAY_US, FailureType
from sitl.records.images import Image, ImageStamp
from sitl.records.motion import VehicleState
from sitl.sensors.camera.camera import Camera
from sitl.sensors.camera.failure import CameraFailure
from sitl.sensors.camera.shutter import Delay, Spoiler

CAMERA_RATE_HZ = 20


class CameraFeed:
    """The images of one camera, one after the other; owns the camera."""

    def __init__(
        self,
        camera: Camera,
        faults: CameraFaults,
        *,
        fault_rng: np.random.Generator,
        failure_rng: np.random.Generator,
    ) -> None:
        """Spoil images by the faults of the day, and by failures that are injected later."""
        self._camera = camera
        self._faults = faults
        self._spoiler = None if faults == CameraFaults() else Spoiler(faults, fault_rng)
        self._failure = CameraFailure(failure_rng)
        self._schedule = Schedule(CAMERA_RATE_HZ)
        self._sequence = 0
        self._latency_s = faults.latency_s
        self._delay = Delay(faults.latency_s) if faults.latency_s > 0.0 else None

    def close(self) -> None:
        """Free the renderer."""
        self._camera.close()

    def fail(self, kind: FailureType, time_us: int) -> None:
        """Fail from now on, or be well again; what is under way comes out if the delay stays."""
        self._failure.begin(kind, time_us)
        delay_s = DELAY_US / SECOND_US if kind is FailureType.DELAYED else 0.0
        latency_s = self._faults.latency_s + delay_s
        if latency_s != self._latency_s:
            self._latency_s = latency_s
            self._delay = Delay(latency_s) if latency_s > 0.0 else None

    def is_due(self, state: VehicleState) -> bool:
        """Whether an image comes out now; true once for each."""
        time_us = state.time_us
        is_taken = self._schedule.due(time_us) and self._failure.lets_through(time_us)
        if self._delay is None:
            return is_taken
        if is_taken:
            self._delay.put(self._take(state))
        return self._delay.is_due(time_us)

    def stamp(self, time_us: int) -> ImageStamp:
        """Time and number of the image that `give` gives."""
        if self._delay is None:
            return ImageStamp(time_us, self._sequence)
        return self._delay.first_stamp

    def give(self, state: VehicleState) -> Image:
        """Give the image out that is due: one of this moment, unless the camera is late."""
        return self._take(state) if self._delay is None else self._delay.take()

    def _take(self, state: VehicleState) -> Image:
        rgb = self._camera.render(state.position_ned, state.q_ned_frd)
        if self._spoiler is not None:
            rgb = self._spoiler.spoil(rgb)
        image = Image(time_us=state.time_us, sequence=self._sequence, rgb=rgb)
        self._sequence += 1
        return self._failure.spoil(image)
