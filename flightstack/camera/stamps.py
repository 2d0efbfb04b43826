"""Believe a camera's stamps while they can be the vehicle's time; else date images by arrival.

A camera that sends the time since 1970, or since its own start, would otherwise set the clock by
which everything is timed; its stamps still tell how its images lie in time to each other. An image
that comes late keeps its stamp: the mission holds for it. Where the vehicle has announced the
image, the time that it has announced is better than that of arrival.
"""

from dataclasses import replace

from flightstack.camera.mailbox import Arrival
from flightstack.camera.stream_clock import StreamClock
from flightstack.clock import REBOOT_US, VehicleClock
from flightstack.records import Image

MAX_AHEAD_US = 2_000_000  # of all that has been told: in lockstep an image is one period ahead
MAX_BEHIND_US = REBOOT_US
RECENT_US = 500_000
MAX_TOLD_S = 1e11  # 3,000 years: what is larger has lost the milliseconds


class StampCheck:
    """Compare each image's stamp with the vehicle's clock; for the thread that observes it.

    `latency_s` is what passes between exposure and the moment by which an image without a stamp is
    dated: when the sensor says that it took it, else when it was received.
    """

    def __init__(self, clock: VehicleClock, latency_s: float = 0.0) -> None:
        self.complaint = ""  # what was wrong with the newest image's stamp
        self._announced_us: int | None = None  # the newest that has stood in for a stamp
        self._dated_us = 0  # the newest that was dated by us
        self._clock = clock
        self._latency_s = latency_s
        self._camera_clock = StreamClock()

    def admit(self, arrival: Arrival, announced_us: int | None = None) -> Arrival:
        """Return the image as it is, or with a better time in place of its stamp.

        `announced_us` is the newest image of which the vehicle has told, where it does tell.
        """
        self.complaint = arrival.odd_stamp and "no time of this vehicle"
        if arrival.stamped:
            self.complaint = self._odds(arrival.image.stamp_us)
            if not self.complaint:
                return arrival
        if self.complaint and announced_us is not None and self._is_new(announced_us):
            self._announced_us = announced_us
            return self._dated(arrival, announced_us, stamped=True)
        return self._dated(arrival, self._taken_us(arrival), stamped=False)

    def aged(self, arrival: Arrival) -> Image:
        """Return an admitted image with its age, once its stamp has been observed.

        Where the vehicle has not said how its clock runs, a stamped image is as old as telemetry
        proves: in lockstep, where time waits for the image, it is not old at all.
        """
        stamp_us = arrival.image.stamp_us
        measured = self._clock.synchronised or not arrival.stamped
        now_us = self._clock.at_us(arrival.received_s) if measured else self._clock.stamp_us
        if now_us <= stamp_us:
            return arrival.image
        return replace(arrival.image, age_s=(now_us - stamp_us) / 1e6)

    def _taken_us(self, arrival: Arrival) -> int:
        """Say when an image was exposed; never before the one that came before it."""
        known_s = arrival.taken_s
        if known_s is None:
            told_s = _told_s(arrival)
            known_s = arrival.received_s
            if told_s is not None:
                known_s = self._camera_clock.left_s(told_s, known_s)
        taken_us = self._clock.at_us(known_s - self._latency_s)
        if self._dated_us - REBOOT_US < taken_us <= self._dated_us:  # our clock was put right
            taken_us = self._dated_us + 1
        self._dated_us = taken_us
        return taken_us

    @staticmethod
    def _dated(arrival: Arrival, stamp_us: int, *, stamped: bool) -> Arrival:
        return replace(arrival, image=replace(arrival.image, stamp_us=stamp_us), stamped=stamped)

    def _is_new(self, announced_us: int) -> bool:
        """Whether this can be the image that has just come."""
        recent = abs(self._clock.stamp_us - announced_us) <= RECENT_US
        return recent and announced_us != self._announced_us

    def _odds(self, stamp_us: int) -> str:
        if not self._clock.started:
            return ""
        ahead_us = stamp_us - self._clock.stamp_us
        if ahead_us > MAX_AHEAD_US:
            return "ahead of the vehicle's time"
        return "behind the vehicle's time" if ahead_us < -MAX_BEHIND_US else ""


def _told_s(arrival: Arrival) -> float | None:
    """Return what a camera says, on a clock of its own; None where it says nothing."""
    if not arrival.odd_stamp:
        return arrival.image.stamp_us / 1e6 if arrival.stamped else None
    try:
        told_s = float(arrival.odd_stamp)
    except ValueError:
        return None
    return told_s if abs(told_s) < MAX_TOLD_S else None
