"""Answer each camera image with one setpoint, and let the mission move on by what is then known.

The loop sleeps until an image is there. While images flow, telemetry wakes it once before, to be
logged while the vehicle still draws; where no image comes soon, every datagram wakes it. Everything
that matters happens when an image is handled, in this order: telemetry is taken in, the mission
advances, the pilot decides, and commands, heartbeat, uncertainty and last the setpoint go out, on
which a vehicle in lockstep runs on. So a flight in lockstep does not depend on when the threads of
either process ran.
"""

import math

from flightstack.camera.mailbox import Arrival
from flightstack.camera.stamps import StampCheck
from flightstack.camera.watch import ImageWatch
from flightstack.clock import REBOOT_US
from flightstack.companion.guards.limits import FlightLimits
from flightstack.companion.guards.one_pilot import OnePilot
from flightstack.companion.guards.steering import Steering
from flightstack.companion.imaging import ImageQueue, Recorder
from flightstack.companion.latencies import Latencies
from flightstack.companion.mission.hold import hold_for_camera
from flightstack.companion.mission.machine import advance
from flightstack.companion.mission.records import (
    Hold,
    MissionPhase,
    MissionStatus,
    Outcome,
    Situation,
)
from flightstack.companion.mission.table import OURS
from flightstack.companion.piloting.protocols import GuardedPilot
from flightstack.companion.reporter import Reporter, announcement
from flightstack.companion.signals import StopSwitch
from flightstack.companion.vehicle_session import VehicleSession
from flightstack.companion.waiting import wait_for_any
from flightstack.mavlink.offboard import STILL
from flightstack.records import Image

IDLE_S = 0.1  # wall time: how long the loop sleeps at most
IMAGE_SOON_S = 0.03  # wall time: telemetry waits so long for the image that it belongs to
TRIGGER_WAIT_S = 0.05  # wall time: for the announcement of an image that has come
LINK_LOST_S = 3.0  # wall time
LONG_S = 1e6  # stands for endless silence
TICK_US = 50_000  # vehicle time: the pace without images
REPEAT_S = 1.0  # wall time without an image, while vehicle time stands
STALLED_US = 1_500_000  # vehicle time without an image
RESTART_S = 1.0  # wall time without one, and between two attempts
STALLED_S = 5.0  # wall time without one, whatever the vehicle's clock does
IMAGES_LOST_S = 10.0  # wall time: a camera is lost even where no telemetry tells the time
STEERED = (MissionPhase.ENTERING_OFFBOARD, MissionPhase.FLYING)


class FlightLoop:
    """One flight, from the first image to the last."""

    def __init__(  # noqa: PLR0913  (what a flight is made of, by name)
        self,
        vehicle: VehicleSession,
        camera: ImageQueue,
        pilot: GuardedPilot,
        reporter: Reporter,
        *,
        mission: MissionStatus | None = None,
        speed_scale: float = 1.0,
        limits: FlightLimits | None = None,
        recorder: Recorder | None = None,
        camera_latency_s: float = 0.0,
    ) -> None:
        self.status = MissionStatus() if mission is None else mission
        self.stop = StopSwitch()
        self.holds: dict[Outcome, Hold] = {}  # of anybody but the camera, until taken back
        self.images = 0
        self.latencies_s = Latencies()
        self._vehicle = vehicle
        self._clock = vehicle.link.clock
        self._camera = camera
        self._steering = Steering(
            pilot,
            vehicle,
            reporter,
            self.holds,
            speed_scale=speed_scale,
            limits=limits or FlightLimits(),
        )
        self._reporter = reporter
        self._recorder = recorder
        self._one_pilot = OnePilot()
        self._stamps = StampCheck(self._clock, camera_latency_s)
        self._images = ImageWatch(camera.announced_hz)
        self._answered_us: int | None = None  # the newest image that was
        self._image_us = self._ticked_us = self._clock.stamp_us
        self._image_s = self._steered_s = self._restarted_s = self._clock.wall_s()
        self._images_flow = False  # the last turn of the loop has answered one
        self._unanswered: Arrival | None = None  # has come while the vehicle was silent

    def run(self) -> None:
        """Fly until the mission is done or the vehicle is lost; land on any other way out."""
        try:
            while self.status.phase is not MissionPhase.DONE:
                try:
                    self._turn()
                except Exception as error:  # whatever it is, the vehicle is in the air
                    self._steering.stumble(error, self._clock.stamp_us)
        finally:
            if self.status.phase in OURS:
                self._vehicle.abandon()

    def _turn(self) -> None:
        self._sleep()
        self._vehicle.receive()
        if self._vehicle.link.silence_s > LINK_LOST_S:
            self._vehicle.receive()  # it may be we who stood still: then it has said something
        if self._vehicle.link.silence_s > LINK_LOST_S:
            self._call()
            return
        self._heed_restart()
        arrival = self._camera.take() or self._unanswered
        self._unanswered = None
        self._images_flow = arrival is not None
        if arrival is not None:
            self._answer(arrival)
        else:
            self._watch()
        self._vehicle.link.tlog.flush_if_due()
        self._reporter.report(self.status, self._vehicle)

    def _sleep(self) -> None:
        """Wait for the next image; while images flow, telemetry that comes before it wakes once."""
        if self._images_flow and wait_for_any(IMAGE_SOON_S, self._vehicle.link, self._camera):
            self._vehicle.receive()
            if wait_for_any(IMAGE_SOON_S, self._camera):
                return
        wait_for_any(IDLE_S, self._vehicle.link, self._camera)

    def _call(self) -> None:
        """Keep calling a vehicle that is silent; the wall's time stands in for its own."""
        self._images_flow = False
        self._unanswered = self._camera.take() or self._unanswered
        self._vehicle.lose_sight()
        if self.stop.requested:
            self._reporter.warn_once("the vehicle is still called: a second Ctrl-C ends at once")
        silence_s = min(self._vehicle.link.silence_s, LONG_S)
        now_us = self._clock.stamp_us + round(silence_s * 1e6)
        self._advance(now_us, vehicle_silent=True)
        if self.status.phase is not MissionPhase.DONE:
            self._vehicle.keep_up(now_us)
        self._vehicle.link.tlog.flush_if_due()
        self._reporter.report(self.status, self._vehicle)

    def _heed_restart(self) -> None:
        """Let the mission know that the vehicle's time has begun anew, and count from there."""
        before_us = self._vehicle.take_restart()
        if before_us is not None:
            self._answered_us = None
            now_us = self._image_us = self._ticked_us = self._clock.stamp_us
            self._advance(now_us, restarted_us=before_us)

    def _answer(self, arrival: Arrival) -> None:
        arrival = self._stamps.admit(arrival, self._vehicle.telemetry.trigger_us)
        if self._stamps.complaint:
            self._reporter.warn_once(
                f"the camera's stamps are {self._stamps.complaint}: images are dated here"
            )
        stamp_us = arrival.image.stamp_us
        if arrival.stamped:
            if self._is_old(stamp_us):
                self._vehicle.repeat_setpoint()
                return
            self._await_trigger(stamp_us)
            self._clock.observe(stamp_us)
            self._answered_us = stamp_us
        else:
            self._vehicle.timesync.begin()
        image = self._stamps.aged(arrival)
        self._look(image)
        self._image_us, self._image_s = image.stamp_us, self._clock.wall_s()
        self.images += 1
        if self.status.phase is MissionPhase.FLYING:
            self._steering.watch_limits(image.stamp_us)
        self._tick(image.stamp_us)
        if self.status.outcome is Outcome.OTHER_PILOT:
            return  # whose vehicle it is: not one setpoint more
        sees = self._images.complaint is None and self._steering.may_decide
        flies = self.status.phase is MissionPhase.FLYING and sees
        if flies:
            velocities = self._steering.decide(image, self._camera)
        else:
            velocities = self._steering.stand_still(image)
        self._vehicle.keep_up(image.stamp_us)
        self._vehicle.steer(velocities, image.stamp_us)
        self._one_pilot.note_setpoint(velocities)
        self._steered_s = self._clock.wall_s()
        if flies:
            self.latencies_s.append(self._clock.wall_s() - arrival.received_s)
        if self._recorder is not None:  # last of all: nothing waits for it now
            self._recorder.record(image)

    def _is_old(self, stamp_us: int) -> bool:
        """Whether an image has been answered, or one after it: a new connection begins with it."""
        newest_us = self._answered_us
        return newest_us is not None and newest_us - REBOOT_US < stamp_us <= newest_us

    def _look(self, image: Image) -> None:
        """Hold, from the next tick on, for a camera whose images cannot be what it sees."""
        velocity = self._vehicle.telemetry.velocity_ned
        unknown = math.inf if self.status.phase is MissionPhase.FLYING else 0.0
        speed_m_s = unknown if velocity is None else math.hypot(*velocity)
        complaint = self._images.look(image, speed_m_s)
        if complaint is not None:
            self._reporter.warn_once(f"the camera {complaint.what}: the vehicle is held")

    def _await_trigger(self, stamp_us: int) -> None:
        """Wait until the vehicle's telemetry has come up to the image, where it announces them."""
        deadline_s = self._clock.wall_s() + TRIGGER_WAIT_S
        while (announced_us := self._vehicle.telemetry.trigger_us) is not None:
            left_s = deadline_s - self._clock.wall_s()
            if announced_us >= stamp_us or left_s <= 0:
                return
            wait_for_any(left_s, self._vehicle.link)
            self._vehicle.receive()

    def _watch(self) -> None:
        """Keep the mission going while no image comes."""
        self._vehicle.keep_up(self._ticked_us)
        self._repeat_setpoint()
        now_us = self._time_without_images_us()
        self._restart_camera(now_us)
        self._ticked_us = min(self._ticked_us, now_us)
        waits = (
            hold_for_camera(self._image_us, now_us) is None or now_us - self._ticked_us < TICK_US
        )
        if waits and self.status.phase is not MissionPhase.REACHING:  # whose time may stand still
            return
        self._tick(now_us)
        self._vehicle.keep_up(now_us)
        if self.status.phase in STEERED and self.status.hold is not None:
            self._vehicle.steer(STILL, now_us)

    def _repeat_setpoint(self) -> None:
        """Answer the image once more if a vehicle that is alive stands still: the answer got lost.

        One that is silent gets nothing, so that it may leave OFFBOARD by its own failsafe.
        """
        now_s = self._clock.wall_s()
        stands = self._clock.stamp_us <= self._image_us
        seen = self._vehicle.telemetry.heartbeat_us is not None  # since it was last given up
        alive = seen and self._vehicle.link.silence_s < REPEAT_S / 2
        if stands and alive and now_s - self._steered_s >= REPEAT_S:
            self._steered_s = now_s
            self._vehicle.repeat_setpoint()

    def _restart_camera(self, now_us: int) -> None:
        """Have a stream opened again that has stalled, by either clock; again after a while."""
        now_s = self._clock.wall_s()
        without_s = now_s - max(self._image_s, self._restarted_s)
        stalls = now_us - self._image_us > STALLED_US and without_s > RESTART_S
        if stalls or without_s > STALLED_S:
            self._restarted_s = now_s
            self._camera.restart()

    def _time_without_images_us(self) -> int:
        """Vehicle time as telemetry tells it, or the wall where that has stood still for long."""
        without_s = self._clock.wall_s() - self._image_s
        if without_s < IMAGES_LOST_S:
            return self._clock.stamp_us
        return max(self._clock.stamp_us, self._image_us + round(without_s * 1e6))

    def _tick(self, now_us: int) -> None:
        """Let the mission move on, and tell who watches the vehicle when it has."""
        self._ticked_us = now_us
        phase = self.status.phase
        self._advance(now_us)
        self._vehicle.download_course(now_us)
        if self.status.phase is not phase:
            self._vehicle.announce(announcement(self.status))

    def _advance(
        self, now_us: int, *, vehicle_silent: bool = False, restarted_us: int | None = None
    ) -> None:
        telemetry, link = self._vehicle.telemetry, self._vehicle.link
        complaint = self._images.complaint
        situation = Situation(
            vehicle=telemetry,
            image_us=self._image_us,
            holds=tuple(self.holds.values()),
            camera_lies_us=None if complaint is None else complaint.since_us,
            stop_requested=self.stop.requested,
            vehicle_silent=vehicle_silent,
            vehicle_gone=link.closed,
            restarted_us=restarted_us,
            other_pilot=self._one_pilot.has_other(self.status.phase, telemetry, link.others),
        )
        self.status, requests = advance(self.status, situation, now_us)
        for request in requests:
            self._vehicle.request(request, now_us)
