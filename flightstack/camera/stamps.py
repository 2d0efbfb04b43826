"""Believe a camera's stamps while they can be the vehicle's time; else date images by arrival.

A camera that sends the time since 1970, or since its own start, would otherwise set the clock by
which everything is timed. An image that comes late keeps its stamp: the mission holds for it.
"""

from dataclasses import replace

from flightstack.camera.mailbox import Arrival
from flightstack.clock import REBOOT_US, VehicleClock

MAX_AHEAD_US = 2_000_000  # of all that has been told: in lockstep an image is one period ahead
MAX_BEHIND_US = REBOOT_US


class StampCheck:
    """Compare each image's stamp with the vehicle's clock; for the thread that observes it."""

    def __init__(self, clock: VehicleClock) -> None:
        self.complaint = ""  # what was wrong with the newest image's stamp
        self._clock = clock

    def admit(self, arrival: Arrival) -> Arrival:
        """Return the image as it is, or with the time of its arrival in place of its stamp."""
        self.complaint = arrival.odd_stamp and "no time of this vehicle"
        if arrival.stamped:
            self.complaint = self._odds(arrival.image.stamp_us)
        if not self.complaint:
            return arrival
        since_us = round((self._clock.wall_s() - arrival.received_s) * 1e6)
        stamp_us = max(0, self._clock.now_us() - max(0, since_us))
        return replace(arrival, image=replace(arrival.image, stamp_us=stamp_us), stamped=False)

    def _odds(self, stamp_us: int) -> str:
        if not self._clock.started:
            return ""
        ahead_us = stamp_us - self._clock.stamp_us
        if ahead_us > MAX_AHEAD_US:
            return "ahead of the vehicle's time"
        return "behind the vehicle's time" if ahead_us < -MAX_BEHIND_US else ""
