"""Ask the vehicle for its time, ten times a second: TIMESYNC, as MAVROS asks PX4.

Asked only where somebody needs it: a camera that dates its images by the vehicle's clock needs
none, and a flight in lockstep stays the same to the last bit. The vehicle's own questions stay
without an answer: what is sent from here carries its own time already.
"""

from pymavlink.dialects.v20 import common

from flightstack.mavlink.clock.clock_offset import MAX_TRIP_S, ClockOffset, ClockQuality
from flightstack.mavlink.link import Link, Message

PERIOD_S = 0.1  # wall time; MAVROS's timesync_rate, 10 Hz
NS = 1_000_000_000


class Timesync:
    """The questions, the answers, and the clock that is told; for one thread."""

    def __init__(self, link: Link) -> None:
        self.wanted = False
        self._link = link
        self._offset = ClockOffset()
        self._sent_s: dict[int, float] = {}  # by what the answer will repeat
        self._last_s = 0.0

    @property
    def quality(self) -> ClockQuality | None:
        """How well the vehicle's clock is known; None until enough answers have come."""
        return self._offset.quality()

    def begin(self) -> None:
        """Ask from now on: somebody needs the vehicle's time."""
        if not self.wanted:
            self.wanted = True
            self._link.heed(common.MAVLINK_MSG_ID_TIMESYNC)

    def poll(self) -> None:
        """Ask, if it is time to."""
        now_s = self._link.clock.wall_s()
        if not self.wanted or self._link.vehicle is None or now_s - self._last_s < PERIOD_S:
            return
        self._sent_s = {n: at for n, at in self._sent_s.items() if now_s - at < MAX_TRIP_S}
        self._last_s = now_s = self._link.clock.wall_s()
        number = round(now_s * NS)
        self._sent_s[number] = now_s
        self._link.send(common.MAVLink_timesync_message(0, number))

    def take(self, message: Message) -> None:
        """Take an answer to one of our questions; all else passes by."""
        sent_s = self._sent_s.pop(message.ts1, None)
        if sent_s is None or message.tc1 <= 0:
            return
        clock = self._link.clock
        self._offset.add(sent_s, message.tc1 / NS, clock.wall_s())
        clock.synchronise(self._offset.line())

    def begin_anew(self) -> None:
        """Forget the clock of a vehicle that has restarted."""
        self._sent_s.clear()
        self._offset.begin_anew()
