"""Decide when vehicle time may pass in lockstep: not before the last camera image is answered.

    standing --a viewer answers image 0--> locked <--answered-- free
                                             |                    ^
                                             `--no viewer left, ---'
                                                or no answer for 10 s of wall time

Standing and waiting, the vehicle handles whatever comes in, at one and the same vehicle time.
Locked and answered, it runs to the next image and reads nothing, so that what happens depends on
the order of messages alone, never on wall time. Free, time passes at the pace of the wall clock.
A real PX4, whose clock is ours, has to boot before anybody answers: with it, free is the beginning.
A camera that fails gives nothing to answer: after 1.5 s of it messages are read at any time.
"""

import logging

PATIENCE_S = 10.0  # wall time

_log = logging.getLogger(__name__)


class Lockstep:
    """Follow images and answers. Wall time comes in as an argument."""

    def __init__(self, *, starts_free: bool = False) -> None:
        """Stand until the first answer; or run free until then, where an autopilot has to boot."""
        self._started = starts_free
        self._answered = False  # the newest image
        self._image_us = 0
        self._image_wall_s = 0.0
        self._free = starts_free
        self._warned = False

    def image_published(self, time_us: int, now_s: float) -> None:
        """Note a new image: it wants an answer."""
        self._image_us, self._image_wall_s = time_us, now_s
        self._answered = False

    def setpoint_received(self, answered_us: int, *, has_viewers: bool) -> None:
        """Note a setpoint that answers the image of `answered_us`."""
        if answered_us < self._image_us or not (self._started or has_viewers):
            return
        self._answered = self._started = True
        self._free = not has_viewers

    def may_advance(self, now_s: float, *, has_viewers: bool) -> bool:
        """Whether time may pass now."""
        if not self._started:
            return False
        if not has_viewers:
            self._free = True
        elif not self._answered and not self._free and now_s - self._image_wall_s > PATIENCE_S:
            self._warn()
            self._free = True
        return self._answered or self._free

    @property
    def is_free(self) -> bool:
        """Whether time passes at the pace of the wall clock, and messages are read at any time."""
        return self._free

    def _warn(self) -> None:
        if not self._warned:
            _log.warning(
                "lockstep: image %.3f s unanswered for %.0f s; running free until one is",
                self._image_us / 1e6,
                PATIENCE_S,
            )
        self._warned = True
