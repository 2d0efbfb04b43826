"""Turn what a pilot decides into the velocities to send, and its failures into a hold."""

from dataclasses import replace

from flightstack.companion.guards.limits import FlightLimits
from flightstack.companion.guards.patience import FramePatience
from flightstack.companion.mission.hold import (
    hold_for_error,
    hold_for_late_part,
    hold_for_part,
    hold_outside,
)
from flightstack.companion.mission.records import Hold, Outcome
from flightstack.companion.piloting.failure import PartFailure
from flightstack.companion.piloting.protocols import GuardedPilot
from flightstack.companion.reporter import Reporter
from flightstack.companion.vehicle_session import VehicleSession
from flightstack.companion.waiting import Readable
from flightstack.mavlink.offboard import STILL, Velocities
from flightstack.records import Image

LATE_OFTEN = 10  # images: a machine may be busy for once
MAX_STUMBLES = 1000  # a minute of images
PART, OUTSIDE = Outcome.PART_FAILED, Outcome.OUT_OF_LIMITS


class Steering:
    """Asks the pilot for each image; `holds` are the loop's, by reason."""

    def __init__(
        self,
        pilot: GuardedPilot,
        vehicle: VehicleSession,
        reporter: Reporter,
        holds: dict[Outcome, Hold],
        *,
        speed_scale: float = 1.0,
        limits: FlightLimits,
    ) -> None:
        self._pilot, self._vehicle, self._reporter = pilot, vehicle, reporter
        self._holds = holds
        self._speed_scale, self._limits = speed_scale, limits
        self._decided_us: int | None = None  # stamp of the image of the newest decision
        self._velocities = STILL  # of it
        self._stumbles = 0  # errors of our own
        self._late = 0  # images without a decision of their own

    @property
    def may_decide(self) -> bool:
        """Whether nothing but the pilot itself has the vehicle held."""
        return self._holds.keys() <= {PART}

    def decide(self, image: Image, camera: Readable) -> Velocities:
        """Say what answers this image."""
        if self._decided_us is None:
            self._decided_us = image.stamp_us
        patience = FramePatience(self._vehicle, camera, image.stamp_us)
        decision = self._pilot.decide(image, patience)
        if isinstance(decision, PartFailure):
            return self._hold_for(decision, image.stamp_us)
        if decision is None:
            return self._go_on_without(image.stamp_us)
        self._decided_us = image.stamp_us
        self._holds.pop(PART, None)
        decision = replace(decision, command=decision.command * self._speed_scale)
        self._vehicle.explain(decision, image)
        self._reporter.note_decision(decision)
        forward, right, down, yaw_rate = decision.command.tolist()
        self._velocities = (forward, right, down, yaw_rate)
        return self._limits.clip(self._velocities, self._vehicle.telemetry)

    def watch_limits(self, now_us: int) -> None:
        """Hold a vehicle that is outside its limits, for as long as it is."""
        breach = self._limits.breach(self._vehicle.telemetry)
        if breach is None:
            self._holds.pop(OUTSIDE, None)
        elif OUTSIDE not in self._holds:
            self._reporter.warn_once(f"the vehicle {breach} is its limit: it is held")
            self._holds[OUTSIDE] = hold_outside(now_us)

    def stumble(self, error: Exception, now_us: int) -> None:
        """Hold, then land, after an error of our own; raise it where it comes at every turn."""
        self._stumbles += 1
        self._reporter.warn_of_error(error)
        self._holds.setdefault(Outcome.COMPANION_FAILED, hold_for_error(now_us))
        if self._stumbles >= MAX_STUMBLES:
            raise error

    def stand_still(self, image: Image) -> Velocities:
        """Look after the pilot while the vehicle is to stand still."""
        failure = self._pilot.check()
        return STILL if failure is None else self._hold_for(failure, image.stamp_us)

    def _hold_for(self, failure: PartFailure, now_us: int) -> Velocities:
        """Hold for a part that gave nothing; the next good decision takes it back."""
        self._reporter.warn_once(f"{failure}: the vehicle is held")
        self._holds.setdefault(PART, hold_for_part(now_us))
        return STILL

    def _go_on_without(self, now_us: int) -> Velocities:
        """Repeat the last decision while the pilot thinks, for as long as for a late image."""
        hold = hold_for_late_part(self._decided_us or now_us, now_us)
        if hold is None:
            self._late += 1
            if self._late == LATE_OFTEN:
                self._reporter.warn_once(
                    f"{self._pilot.part} is slower than the camera: decisions are repeated"
                )
            return self._limits.clip(self._velocities, self._vehicle.telemetry)
        self._reporter.warn_once(
            f"{self._pilot.part} has not answered for 0.5 s: the vehicle is held"
        )
        self._holds.setdefault(PART, hold)
        return STILL
