"""What a pilot is, what is made of one that may fail, and who waits for its answers."""

from collections.abc import Callable
from typing import Protocol

from flightstack.companion.piloting.failure import PartFailure, PartMarker
from flightstack.companion.waiting import Readable
from flightstack.records import Decision, Image


class Pilot(Protocol):
    """What looks at an image and says where to fly."""

    def decide(self, image: Image) -> Decision:
        """Decide on the velocities that answer this image."""


PilotMaker = Callable[[], Pilot]  # a new one each time, all chance from the same seed
PilotLoader = Callable[[PartMarker], PilotMaker]


class Patience(Protocol):
    """Somebody who waits for the pilot, and goes on meanwhile."""

    @property
    def over(self) -> bool:
        """Whether the flight has gone on without an answer."""

    def wait(self, source: Readable) -> bool:
        """Wait a moment for the pilot's answer; say whether it is there."""


class GuardedPilot(Protocol):
    """A pilot whose faults are answers."""

    image_s: float  # wall time of one decision, when it was tried

    @property
    def part(self) -> str:
        """Which part is at work."""

    def check(self) -> PartFailure | None:
        """Say why it will never decide again; None while it may."""

    def decide(self, image: Image, patience: Patience) -> Decision | PartFailure | None:
        """Decide on the velocities that answer this image; None where the flight has gone on."""

    def close(self) -> None:
        """Let go of what it holds."""
