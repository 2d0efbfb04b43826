"""What is broken outside the sensors: motors and the radio."""

import numpy as np

from sitl.records.failures import Failure, FailureType, FailureUnit, is_gone
from sitl.records.motion import MotorThrusts
from sitl.sensors.fault import Fault
from sitl.sensors.noise import normals

ALL_MOTORS = range(4)
GARBAGE_THRUST = 0.5  # the size of what a motor does by chance, or wrongly


class Breakage:
    """Keeps what fails, and since when; without failures everything passes unchanged."""

    def __init__(self, rng: np.random.Generator) -> None:
        self._noise = normals(rng)
        self._motors: dict[int, Fault] = {}
        self._last: MotorThrusts = (0.0, 0.0, 0.0, 0.0)
        self._signal_since_us = 0
        self.signal_fault = FailureType.OK  # what is wrong with the radio

    def fail(self, failure: Failure, time_us: int) -> None:
        """Break something, or repair it."""
        if failure.unit is FailureUnit.MAVLINK_SIGNAL:
            self.signal_fault, self._signal_since_us = failure.type, time_us
        elif failure.unit is FailureUnit.MOTOR:
            which = [failure.instance - 1] if failure.instance else ALL_MOTORS
            for motor in which:
                self._motors.pop(motor, None)
                if failure.type is not FailureType.OK:
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

    def is_silent(self, time_us: int) -> bool:
        """Whether the radio carries nothing, either way."""
        if self.signal_fault is FailureType.INTERMITTENT:
            return is_gone(self._signal_since_us, time_us)
        return self.signal_fault is FailureType.OFF
