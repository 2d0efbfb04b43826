"""A pilot in our own process, for parts that come along: what it raises or gives is checked."""

import time

import numpy as np

from flightstack.companion.piloting.check import fault_of
from flightstack.companion.piloting.failure import PartFailure, PartMarker, explain
from flightstack.companion.piloting.protocols import Patience, Pilot, PilotLoader
from flightstack.errors import ModelError
from flightstack.records import Decision, Image

TRIED_IMAGES = 5  # the first are slow: libraries warm up
IMAGE_SIZE = 64


class InProcessPilot:
    """Turns whatever goes wrong in a pilot into a failure for this one image."""

    def __init__(
        self, pilot: Pilot, marker: PartMarker | None = None, *, image_s: float = 0.0
    ) -> None:
        self.image_s = image_s  # wall time of one decision, when it was tried
        self._pilot = pilot
        self._marker = PartMarker() if marker is None else marker

    @property
    def part(self) -> str:
        """Which part is at work."""
        return self._marker.part

    def check(self) -> PartFailure | None:
        """Say that it may decide again: not even a part that raised is given up."""
        return None

    def decide(self, image: Image, patience: Patience | None = None) -> Decision | PartFailure:  # noqa: ARG002  (nobody can be kept waiting)
        """Decide on the velocities that answer this image."""
        try:
            decision = self._pilot.decide(image)
        except Exception as error:  # a part may raise anything
            return PartFailure(part=self._marker.part, reason=explain(error))
        fault = fault_of(decision)
        return decision if fault is None else PartFailure(part=self._marker.part, reason=fault)

    def close(self) -> None:
        """Do nothing: it ends with us."""


def start_in_process(load: PilotLoader) -> InProcessPilot:
    """Load a pilot and try it; raises ModelError where it gives nothing that can be flown by."""
    marker = PartMarker()
    make = load(marker)
    tried = try_pilot(make(), marker)
    if isinstance(tried, PartFailure):
        raise ModelError(f"{tried}, when it was tried on a made-up image")
    return InProcessPilot(make(), marker, image_s=tried)


def try_pilot(pilot: Pilot, marker: PartMarker) -> float | PartFailure:
    """Return the wall time (s) of one decision, the least of several; or the first failure."""
    rng = np.random.default_rng(0)
    tried = InProcessPilot(pilot, marker)
    least_s = float("inf")
    for number in range(TRIED_IMAGES):
        rgb = rng.integers(0, 256, (IMAGE_SIZE, IMAGE_SIZE, 3), np.uint8)
        began_s = time.monotonic()
        answer = tried.decide(Image(stamp_us=number, sequence=number, rgb=rgb))
        if isinstance(answer, PartFailure):
            return answer
        least_s = min(least_s, time.monotonic() - began_s)
    return least_s
