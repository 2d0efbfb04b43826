"""Answer each camera frame with one setpoint, and let the mission move on by what is then known.

The loop sleeps until a frame is there. While frames flow, telemetry wakes it once before, to be
logged while the vehicle still draws; where no frame comes soon, every datagram wakes it. Everything
that matters happens when a frame is handled, in this order: telemetry is taken in, the mission
advances, the pilot decides, and commands, heartbeat, uncertainty and last the setpoint go out, on
which a vehicle in lockstep runs on. So a flight in lockstep does not depend on when the threads of
either process ran.
"""

from dataclasses import replace
from typing import Protocol

import numpy as np

from flightstack.camera.mailbox import Arrival
from flightstack.companion.mission import advance
from flightstack.companion.mission_state import MissionState, Outcome, Phase, Situation
from flightstack.companion.reporter import Reporter, announcement
from flightstack.companion.signals import StopSwitch
from flightstack.companion.vehicle import Vehicle
from flightstack.companion.waiting import wait_for_any
from flightstack.mavlink.offboard import HOLD, Velocities
from flightstack.records import Decision, Frame

IDLE_S = 0.1  # wall time: how long the loop sleeps at most
FRAME_SOON_S = 0.03  # wall time: telemetry waits so long for the frame that it belongs to
TRIGGER_WAIT_S = 0.05  # wall time: for the announcement of a frame that has come
LINK_LOST_S = 3.0  # wall time
FRAME_LATE_US = 500_000  # vehicle time: the vehicle is then held
TICK_US = 50_000  # vehicle time: the pace without frames
REPEAT_S = 1.0  # wall time without a frame, while vehicle time stands
FRAMES_LOST_S = 10.0  # wall time: a camera is lost even where no telemetry tells the time
STEERED = (Phase.ENTERING_OFFBOARD, Phase.FLYING)
NOT_OURS = (Phase.WAITING, Phase.TAKEN_OVER, Phase.DONE)


class Pilot(Protocol):
    """What looks at a frame and says where to fly."""

    def decide(self, frame: Frame) -> Decision:
        """Decide on the velocities that answer this frame."""


class FrameQueue(Protocol):
    """Where frames come from, ready for a selector."""

    @property
    def stamped(self) -> bool:
        """Whether frames carry the vehicle's own stamps."""

    def fileno(self) -> int:
        """Return what a selector waits on."""

    def take(self) -> Arrival | None:
        """Take the newest frame, if it has not been taken."""


class Recorder(Protocol):
    """Where frames are kept."""

    def record(self, frame: Frame) -> None:
        """Have a frame kept; never waits."""


class FlightLoop:
    """One flight, from the first frame to the last."""

    def __init__(
        self,
        vehicle: Vehicle,
        camera: FrameQueue,
        pilot: Pilot,
        reporter: Reporter,
        *,
        mission: MissionState | None = None,
        speed_scale: float = 1.0,
        recorder: Recorder | None = None,
    ) -> None:
        self.state = MissionState() if mission is None else mission
        self.stop = StopSwitch()
        self.frames = 0
        self.latencies_s: list[float] = []
        self._vehicle = vehicle
        self._clock = vehicle.link.clock
        self._camera = camera
        self._pilot = pilot
        self._reporter = reporter
        self._speed_scale = speed_scale
        self._recorder = recorder
        self._frame_us = self._clock.stamp_us
        self._frame_s = self._clock.wall_s()
        self._steered_s = self._frame_s
        self._ticked_us = self._clock.stamp_us
        self._frames_flow = False  # the last turn of the loop has answered one

    def run(self) -> None:
        """Fly until the mission is done or the vehicle is lost; land on any other way out."""
        try:
            while self.state.phase is not Phase.DONE:
                self._turn()
        finally:
            if self.state.phase not in NOT_OURS:
                self._vehicle.abandon()

    def _turn(self) -> None:
        self._sleep()
        self._vehicle.receive()
        if self._vehicle.link.silence_s > LINK_LOST_S:
            self._lose_link()
            return
        arrival = self._camera.take()
        self._frames_flow = arrival is not None
        if arrival is not None:
            self._answer(arrival)
        else:
            self._watch()
        self._vehicle.link.tlog.flush_if_due()
        self._reporter.report(self.state, self._vehicle)

    def _sleep(self) -> None:
        """Wait for the next frame; while frames flow, telemetry that comes before it wakes once."""
        if self._frames_flow and wait_for_any(FRAME_SOON_S, self._vehicle.link, self._camera):
            self._vehicle.receive()
            if wait_for_any(FRAME_SOON_S, self._camera):
                return
        wait_for_any(IDLE_S, self._vehicle.link, self._camera)

    def _answer(self, arrival: Arrival) -> None:
        frame = arrival.frame
        if self._camera.stamped:
            self._await_trigger(frame.stamp_us)
            self._clock.observe(frame.stamp_us)
        self._frame_us, self._frame_s = frame.stamp_us, self._clock.wall_s()
        self.frames += 1
        self._advance(frame.stamp_us)
        velocities = self._decide(frame) if self.state.phase is Phase.FLYING else HOLD
        self._vehicle.keep_up(frame.stamp_us)
        self._vehicle.steer(velocities, frame.stamp_us)
        self._steered_s = self._clock.wall_s()
        if self.state.phase is Phase.FLYING:
            self.latencies_s.append(self._clock.wall_s() - arrival.received_s)
        if self._recorder is not None:  # last of all: nothing waits for it now
            self._recorder.record(frame)

    def _await_trigger(self, stamp_us: int) -> None:
        """Wait until the vehicle's telemetry has come up to the frame, where it announces them."""
        deadline_s = self._clock.wall_s() + TRIGGER_WAIT_S
        while (announced_us := self._vehicle.telemetry.trigger_us) is not None:
            left_s = deadline_s - self._clock.wall_s()
            if announced_us >= stamp_us or left_s <= 0:
                return
            wait_for_any(left_s, self._vehicle.link)
            self._vehicle.receive()

    def _decide(self, frame: Frame) -> Velocities:
        decision = self._pilot.decide(frame)
        if not _is_finite(decision):
            self._reporter.warn_once("a decision was not finite: the vehicle is held")
            return HOLD
        decision = replace(decision, command=decision.command * self._speed_scale)
        self._vehicle.explain(decision, frame.stamp_us)
        self._reporter.note_decision(decision)
        forward, right, down, yaw_rate = decision.command.tolist()
        return (forward, right, down, yaw_rate)

    def _watch(self) -> None:
        """Keep the mission going while no frame comes."""
        self._vehicle.keep_up(self._ticked_us)
        self._repeat_setpoint()
        now_us = self._frameless_us()
        if now_us - self._frame_us < FRAME_LATE_US or now_us - self._ticked_us < TICK_US:
            return
        self._advance(now_us)
        self._vehicle.keep_up(now_us)
        if self.state.phase in STEERED:
            self._vehicle.steer(HOLD, now_us)

    def _repeat_setpoint(self) -> None:
        """Answer the frame once more if a vehicle that is alive stands still: the answer got lost.

        One that is silent gets nothing, so that it may leave OFFBOARD by its own failsafe.
        """
        now_s = self._clock.wall_s()
        stands = self._clock.stamp_us <= self._frame_us
        alive = self._vehicle.link.silence_s < REPEAT_S / 2
        if stands and alive and now_s - self._steered_s >= REPEAT_S:
            self._steered_s = now_s
            self._vehicle.repeat_setpoint()

    def _frameless_us(self) -> int:
        """Vehicle time as telemetry tells it, or the wall where that has stood still for long."""
        without_s = self._clock.wall_s() - self._frame_s
        if without_s < FRAMES_LOST_S:
            return self._clock.stamp_us
        return max(self._clock.stamp_us, self._frame_us + round(without_s * 1e6))

    def _advance(self, now_us: int) -> None:
        self._ticked_us = now_us
        phase = self.state.phase
        situation = Situation(
            vehicle=self._vehicle.telemetry,
            frame_us=self._frame_us,
            stop_requested=self.stop.requested,
        )
        self.state, requests = advance(self.state, situation, now_us)
        for request in requests:
            self._vehicle.request(request, now_us)
        self._vehicle.download_course(now_us)
        if self.state.phase is not phase:
            self._vehicle.announce(announcement(self.state))

    def _lose_link(self) -> None:
        ended_us = self.state.ended_us or self._clock.stamp_us
        if self.state.phase not in NOT_OURS:
            self._vehicle.abandon()
        self.state = replace(
            self.state, phase=Phase.DONE, outcome=Outcome.LINK_LOST, ended_us=ended_us
        )
        self._reporter.report(self.state, self._vehicle)


def _is_finite(decision: Decision) -> bool:
    arrays = (
        decision.command,
        decision.aleatoric_std,
        decision.epistemic_std,
        decision.perceptual_std,
        decision.score,
        decision.member_mean,
    )
    return bool(np.isfinite(np.concatenate(arrays, axis=None)).all())
