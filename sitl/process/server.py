"""Run the vehicle on its sockets: one thread, one selector.

Each tick: step the simulation, say the telemetry of that moment on the links, then, if the
camera looks, its CAMERA_TRIGGER, then the image's bytes. What is said leaves before the loop waits
for anything, and before an image. In real time, messages are handled between ticks as they come; in
lockstep only while time stands (see `sitl.process.lockstep`).
"""

import logging
import selectors
import time
from collections.abc import Callable, Sequence
from typing import Protocol

from sitl.clock import TICK_US
from sitl.mavlink.links.link import Link
from sitl.mavlink.wire.refusals import Refusals
from sitl.mavlink.wire.tlog import TlogWriter
from sitl.process.lockstep import Lockstep
from sitl.process.pacing import Pace
from sitl.process.streams.camera_stream import CameraStream
from sitl.process.streams.video import VideoSender
from sitl.records.images import Image, ImageStamp

MAX_WAIT_S = 0.1  # so that a signal is soon seen
STANDING_HEARTBEAT_S = 1.0  # wall time between heartbeats while vehicle time stands
LIST_WAIT_S = TICK_US / 1e6  # pace of parameter lists while vehicle time stands
MAX_DATAGRAMS = 64  # of one link at a time: a flood must not stop the clock
FLUSH_S = 1.0
BLIND_US = 1_500_000  # vehicle time without an image, after which lockstep listens between ticks:
# longer than any gap of a camera that comes back (1.05 s, where it fails intermittently)
TICKS_AT_ONCE = 25  # without looking up, as fast as possible: an image comes every 12 or 13

_log = logging.getLogger(__name__)


class ServedSimulation(Protocol):
    """What is run: a vehicle in its world."""

    @property
    def time_us(self) -> int:
        """Vehicle time since boot."""

    def step(self) -> None:
        """Advance by one tick."""

    def image_due(self) -> bool:
        """Whether the camera looks at this tick; true once for each."""

    @property
    def image_stamp(self) -> ImageStamp:
        """Time and number of the image that `render` gives."""

    def render(self) -> Image:
        """Take an image now."""


class ServedEndpoint(Protocol):
    """What the vehicle says and hears."""

    @property
    def is_ready(self) -> bool:
        """Whether time may pass: there is somebody who flies."""

    @property
    def is_listing(self) -> bool:
        """Whether something long is being sent, though the clock may stand."""

    def take_answer(self) -> int:
        """Give the stamp of the image that a new offboard setpoint answers, -1 if none came."""

    def publish(self) -> None:
        """Send what is due at the present vehicle time."""

    def publish_trigger(self, stamp: ImageStamp) -> None:
        """Announce a camera image, before its bytes go out."""

    def repeat_heartbeats(self) -> None:
        """Say that the vehicle is alive, while its clock stands."""

    def advance_lists(self, elapsed_us: int) -> None:
        """Send more of what is long."""

    def receive(self, link: Link) -> bool:
        """Take one datagram and answer it; False if none waits."""


class Served(Protocol):
    """What needs to be looked after whenever something comes in."""

    def fileno(self) -> int:
        """For a selector."""

    def serve(self, timeout_s: float = 0.0) -> None:
        """Handle what has come in."""


class Server:
    """The loop around a simulation, its MAVLink endpoint and its camera stream."""

    def __init__(
        self,
        simulation: ServedSimulation,
        endpoint: ServedEndpoint,
        links: Sequence[Link],
        stream: CameraStream,
        *,
        speed_factor: float = 1.0,
        lockstep: Lockstep | None = None,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        """Take over open sockets; `clock` is the wall clock in seconds."""
        self._simulation = simulation
        self._endpoint = endpoint
        self._links = links
        self._stream = stream
        self._clock = clock
        self._pace = Pace(speed_factor, clock)
        self._free_pace = Pace(speed_factor or 1.0, clock)
        self._lockstep = lockstep
        self._was_free = True
        self._image_us = 0  # vehicle time of the last image given out
        self._heartbeat_s = self._flush_s = clock()
        self._tlog: TlogWriter | None = None
        self._video: VideoSender | None = None
        self._refusals = Refusals()
        self._each_second: list[Callable[[], None]] = []
        self._stopping = False
        self._selector = selectors.DefaultSelector()
        for link in links:
            link.gather()
            self._selector.register(link, selectors.EVENT_READ, link)
        self.look_after(stream)

    def look_after(self, served: Served) -> None:
        """Serve something more whenever there is something to do for it."""
        self._selector.register(served, selectors.EVENT_READ, served)

    def keep_log(self, tlog: TlogWriter) -> None:
        """Record all traffic from now on; flushed every second."""
        self._tlog = tlog
        for link in self._links:
            link.add_tap(tlog)

    def watch_refusals(self, refusals: Refusals) -> None:
        """Say now and then what was refused."""
        self._refusals = refusals

    def each_second(self, action: Callable[[], None]) -> None:
        """Do something once a second of wall time."""
        self._each_second.append(action)

    def send_video(self, video: VideoSender) -> None:
        """Send every image as video, too."""
        self._video = video

    def stop(self) -> None:
        """Let `run` return soon; may be called from a signal handler."""
        self._stopping = True

    def run(self) -> None:
        """Run until `stop`."""
        self._pace.restart(self._simulation.time_us)
        self._publish()
        while not self._stopping:
            if not self._endpoint.is_ready:
                self._stand()
                self._pace.restart(self._simulation.time_us)
                self._free_pace.restart(self._simulation.time_us)
            elif self._lockstep is None:
                self._run_paced(self._pace)
            else:
                self._run_lockstep(self._lockstep)
            self._flush()
        self._send_gathered()
        self._refusals.report_all()
        self._selector.close()

    def _run_paced(self, pace: Pace) -> None:
        """Handle what has come in, then let one tick pass if it is time."""
        wait_s = pace.wait_s(self._simulation.time_us + TICK_US)
        self._receive(min(wait_s, MAX_WAIT_S))
        if wait_s <= MAX_WAIT_S and pace.wait_s(self._simulation.time_us + TICK_US) == 0.0:
            self._tick()

    def _run_lockstep(self, lockstep: Lockstep) -> None:
        if not lockstep.may_advance(self._clock(), has_viewers=self._stream.has_viewers):
            self._stand()
            return
        pace = self._free_pace if lockstep.is_free else self._pace
        if lockstep.is_free != self._was_free:
            self._was_free = lockstep.is_free
            pace.restart(self._simulation.time_us)
        if lockstep.is_free or self._simulation.time_us - self._image_us > BLIND_US:
            self._run_paced(pace)
            return
        wait_s = pace.wait_s(self._simulation.time_us + TICK_US)
        if wait_s > 0.0:
            self._send_gathered()
            self._stream.serve(min(wait_s, MAX_WAIT_S))
        elif pace.is_unlimited:
            self._run_to_image()
        else:
            self._tick()

    def _run_to_image(self) -> None:
        """Let time pass until there is an image to answer; where none comes, not for ever."""
        for _ in range(TICKS_AT_ONCE):
            if self._tick() or self._stopping:
                return

    def _stand(self) -> None:
        """Handle what comes in while vehicle time stands; say that the vehicle is alive."""
        self._receive(LIST_WAIT_S if self._endpoint.is_listing else MAX_WAIT_S)
        if self._endpoint.is_listing:
            self._endpoint.advance_lists(TICK_US)
        now_s = self._clock()
        if now_s - self._heartbeat_s >= STANDING_HEARTBEAT_S:
            self._heartbeat_s = now_s
            self._endpoint.repeat_heartbeats()

    def _receive(self, timeout_s: float) -> None:
        """Wait for something to come in, and handle it; an answered image ends it in lockstep."""
        self._send_gathered()
        for key, _ in self._selector.select(timeout_s):
            link: Link | Served = key.data
            if not isinstance(link, Link):
                link.serve()
                continue
            for _ in range(MAX_DATAGRAMS):
                if not self._endpoint.receive(link):
                    break
                if self._note_answer():
                    return

    def _note_answer(self) -> bool:
        """Tell the lockstep of a setpoint; whether time may pass now, and did not before."""
        answered_us = self._endpoint.take_answer()
        if self._lockstep is None or answered_us < 0:
            return False
        has_viewers = self._stream.has_viewers
        self._lockstep.setpoint_received(answered_us, has_viewers=has_viewers)
        return self._lockstep.may_advance(self._clock(), has_viewers=has_viewers)

    def _tick(self) -> bool:
        """Let one tick pass; whether it gave an image."""
        self._simulation.step()
        return self._publish()

    def _publish(self) -> bool:
        """Send what belongs to this moment: telemetry, then the trigger, then the image if any.

        Whoever awaits the image reads the others while it is being drawn.
        """
        self._endpoint.publish()
        if not self._simulation.image_due():
            return False
        self._endpoint.publish_trigger(self._simulation.image_stamp)
        self._send_gathered()
        image = self._simulation.render()
        self._image_us = self._simulation.time_us
        self._heartbeat_s = self._clock()
        if self._lockstep is not None:
            self._lockstep.image_published(image.time_us, self._heartbeat_s)
        self._stream.publish(image)
        if self._video is not None:
            self._video.publish(image)
        return True

    def _send_gathered(self) -> None:
        """Send what the links have gathered since the last wait."""
        for link in self._links:
            link.flush()

    def _flush(self) -> None:
        now_s = self._clock()
        if now_s - self._flush_s < FLUSH_S:
            return
        self._flush_s = now_s
        self._refusals.report(now_s)
        for action in self._each_second:
            action()
        if self._tlog is not None:
            self._tlog.flush()
