"""Smooth the body rates as the autopilot does before it flies by them."""

import math

from sitl.clock import SECOND_US, TICK_US
from sitl.records.motion import Vector3

CUTOFF_HZ = 40.0  # PX4 IMU_GYRO_CUTOFF


class GyroFilter:
    """A second-order Butterworth low pass on each axis, one sample per tick; it starts at rest.

    Transposed direct form of the bilinear transform: two numbers of memory per axis.
    """

    def __init__(self, cutoff_hz: float = CUTOFF_HZ) -> None:
        warped = math.tan(math.pi * cutoff_hz * TICK_US / SECOND_US)
        square, damping = warped * warped, math.sqrt(2.0) * warped
        norm = 1.0 + damping + square
        self._b = square / norm
        self._a1, self._a2 = 2.0 * (square - 1.0) / norm, (1.0 - damping + square) / norm
        self._memory: tuple[float, ...] | None = None  # two numbers for each axis

    def restart(self) -> None:
        """Take the next sample for one that has always been there."""
        self._memory = None

    def update(self, rates_frd: Vector3) -> Vector3:
        """Smooth one sample."""
        b, a1, a2 = self._b, self._a1, self._a2
        if self._memory is None:
            at_rest = (1.0 - b, b - a2)
            self._memory = tuple(rate * share for rate in rates_frd for share in at_rest)
        u1, u2, v1, v2, w1, w2 = self._memory
        p, q, r = rates_frd
        x, y, z = b * p + u1, b * q + v1, b * r + w1
        self._memory = (
            2.0 * b * p - a1 * x + u2,
            b * p - a2 * x,
            2.0 * b * q - a1 * y + v2,
            b * q - a2 * y,
            2.0 * b * r - a1 * z + w2,
            b * r - a2 * z,
        )
        return (x, y, z)
