"""What is broken outside the sensors: motors, the radio, the camera."""

import numpy as np

from sitl.records.failures import SLOWER, Failure, FailureType, FailureUnit, is_gone
from sitl.records.images import Image
from sitl.records.motion import MotorThrusts
from sitl.sensors.fault import Fault
from sitl.sensors.noise import normals

ALL_MOTORS = range(4)
GARBAGE_THRUST = 0.5  # the size of what a motor does by chance, or wrongly


class Breakage:
    """Keeps what fails, and since when; without failures everything passes unchanged."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._rng = rng
        self._noise = normals(rng)
        self._motors: dict[int, Fault] = {}
        self._last: MotorThrusts = (0.0, 0.0, 0.0, 0.0)
        self._signal: tuple[FailureType, int] | None = None  # and the time since when
        self._camera: tuple[FailureType, int] | None = None
        self._images = 0
        self._stuck: Image | None = None

    def fail(self, failure: Failure, time_us: int) -> None:
        """Break something, or repair it."""
        kind = None if failure.type is FailureType.OK else (failure.type, time_us)
        if failure.unit is FailureUnit.MAVLINK_SIGNAL:
            self._signal = kind
        elif failure.unit is FailureUnit.CAMERA:
            self._camera, self._stuck = kind, None
        elif failure.unit is FailureUnit.MOTOR:
            which = [failure.instance - 1] if failure.instance else ALL_MOTORS
            for motor in which:
                self._motors.pop(motor, None)
                if kind is not None:
                    self._motors[motor] = Fault(
                        failure.type, size=GARBAGE_THRUST, noise=self._noise, time_us=time_us
                    )

    def drive(self, motors: MotorThrusts, time_us: int) -> MotorThrusts:
        """Give the thrusts that the motors follow."""
        if self._motors:
            thrusts = list(motors)
            for motor, fault in self._motors.items():
                thrusts[motor] = fault.share(thrusts[motor], self._last[motor], time_us)
            a, b, c, d = thrusts
            motors = (a, b, c, d)
        self._last = motors
        return motors

    @property
    def signal_fault(self) -> FailureType:
        """What is wrong with the radio."""
        return FailureType.OK if self._signal is None else self._signal[0]

    def is_silent(self, time_us: int) -> bool:
        """Whether the radio carries nothing, either way."""
        if self._signal is None:
            return False
        kind, since_us = self._signal
        if kind is FailureType.INTERMITTENT:
            return is_gone(since_us, time_us)
        return kind is FailureType.OFF

    def takes_image(self, time_us: int) -> bool:
        """Whether the camera gives the image that is due."""
        if self._camera is None:
            return True
        kind, since_us = self._camera
        self._images += 1
        if kind is FailureType.SLOW:
            return self._images % SLOWER == 0
        if kind is FailureType.INTERMITTENT:
            return not is_gone(since_us, time_us)
        return kind is not FailureType.OFF

    def picture(self, image: Image) -> Image:
        """Give the image as it leaves the camera."""
        if self._camera is None:
            return image
        rgb = image.rgb
        if self._camera[0] is FailureType.GARBAGE:
            rgb = self._rng.integers(0, 256, rgb.shape, dtype=np.uint8)
        elif self._camera[0] is FailureType.STUCK:
            self._stuck = self._stuck or image
            rgb = self._stuck.rgb
        return Image(time_us=image.time_us, sequence=image.sequence, rgb=rgb)
