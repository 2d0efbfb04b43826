"""Watch a camera's images for a while: how many a second, how large, how old, by whose clock."""

import statistics

from flightstack.camera.camera import Camera
from flightstack.camera.mailbox import Arrival
from flightstack.camera.settings import CameraSettings
from flightstack.clock import VehicleClock
from flightstack.companion.readiness.report import ReadinessItem, ReadinessLevel

DEFAULT_HZ = 20.0  # of a camera that does not say
RATE_SLACK = 0.25  # of what was announced
NETWORK_PX = 64
GOOD, ODD = ReadinessLevel.GOOD, ReadinessLevel.ODD


class ImageSurvey:
    """Takes images as they come, and says what they were like."""

    def __init__(self, camera: Camera, clock: VehicleClock) -> None:
        self.images = 0
        self._camera, self._clock = camera, clock
        self._received_s: list[float] = []  # wall time, the first and the last
        self._sizes: set[tuple[int, int]] = set()  # height, width
        self._ages_s: list[float] = []
        self._stamped = False

    def look(self) -> bool:
        """Take the newest image, if there is one; never has enough."""
        arrival = self._camera.take()
        if arrival is not None:
            self.images += 1
            self._received_s = [*self._received_s[:1], arrival.received_s]
            height, width, _ = arrival.image.rgb.shape
            self._sizes.add((height, width))
            self._stamped = arrival.stamped
            if (age_s := self._age_s(arrival)) is not None:
                self._ages_s.append(age_s)
        return False

    def findings(self, settings: CameraSettings, announced_hz: float | None) -> list[ReadinessItem]:
        """Say what was seen."""
        return [self._rate(announced_hz), self._size(settings), self._age(settings.latency_s)]

    def _age_s(self, arrival: Arrival) -> float | None:
        if arrival.stamped:
            now_us = self._clock.at_us(arrival.received_s)
            return (now_us - arrival.image.stamp_us) / 1e6 if self._clock.started else None
        return None if arrival.taken_s is None else arrival.received_s - arrival.taken_s

    def _rate(self, announced_hz: float | None) -> ReadinessItem:
        first_s, last_s = self._received_s[0], self._received_s[-1]
        rate_hz = (self.images - 1) / (last_s - first_s) if last_s > first_s else 0.0
        wanted_hz = announced_hz or DEFAULT_HZ
        return ReadinessItem(
            what="images a second",
            level=ODD if rate_hz < (1.0 - RATE_SLACK) * wanted_hz else GOOD,
            found=f"{rate_hz:.1f}",
            wanted=f"{wanted_hz:g}" + ("" if announced_hz is None else " as announced"),
        )

    def _size(self, settings: CameraSettings) -> ReadinessItem:
        view = settings.view
        lens = "taken for 90 degrees"
        if view is not None:
            lens = f"by --camera-info, shows {100 * view.covered_share:.0f} % of 90 degrees"
        shown = " and ".join(f"{width} x {height}" for height, width in sorted(self._sizes))
        enough = min(min(size) for size in self._sizes) >= NETWORK_PX
        return ReadinessItem(
            what="image",
            level=GOOD if enough else ODD,
            found=f"{shown}, lens {lens}",
            wanted=f"{NETWORK_PX} x {NETWORK_PX} or more",
        )

    def _age(self, latency_s: float) -> ReadinessItem:
        by = "dated by the camera" if self._stamped else "dated by us"
        if self._ages_s:
            found = f"{1e3 * statistics.median(self._ages_s):.0f} ms on arrival, {by}"
            return ReadinessItem(what="image's age", level=GOOD, found=found)
        taken_off = f", {1e3 * latency_s:.0f} ms taken off" if latency_s else ""
        return ReadinessItem(
            what="image's age",
            level=GOOD if latency_s else ODD,
            found=f"not known, {by}{taken_off}",
            wanted="--camera-latency-s, measured",
        )
