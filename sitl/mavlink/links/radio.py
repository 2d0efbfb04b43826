"""A signal that arrives as noise, late, or a little of it: failures injected into the links."""

from collections import deque
from collections.abc import Callable, Sequence

import numpy as np

from sitl.mavlink.links.link import Link
from sitl.mavlink.wire.packets import Received
from sitl.records.failures import DELAY_US, SLOWER, FailureType

SPOILS = {FailureType.GARBAGE, FailureType.SLOW, FailureType.DELAYED}


class BadRadio:
    """Carries what goes either way; while all is well, the links don't know of it."""

    def __init__(self, links: Sequence[Link]) -> None:
        self.kind = FailureType.OK
        self._links = links
        self._time_us = 0
        self._count = 0
        self._chance = np.random.default_rng(0)
        self._out: deque[tuple[int, Callable[[bytes], None], bytes]] = deque()
        self._in: deque[tuple[int, Link, Received]] = deque()

    def advance(self, kind: FailureType, time_us: int) -> list[tuple[Link, Received]]:
        """Be at that time, with that failure: send what is late, give what has come in late."""
        self.kind, self._time_us = kind, time_us
        for link in self._links:
            link.flush()
            link.radio = self if kind in SPOILS else None
        while self._out and self._out[0][0] <= time_us:
            _, transmit, data = self._out.popleft()
            transmit(data)
        heard = []
        while self._in and self._in[0][0] <= time_us:
            _, link, received = self._in.popleft()
            heard.append((link, received))
        return heard

    @property
    def is_idle(self) -> bool:
        """Whether nothing is wrong, and nothing under way."""
        return self.kind not in SPOILS and not self._out and not self._in

    def carry(self, data: bytes, transmit: Callable[[bytes], None]) -> None:
        """Send bytes as far as the failure lets them."""
        if self.kind is FailureType.GARBAGE:
            transmit(self._chance.bytes(len(data)))
        elif self.kind is FailureType.DELAYED:
            self._out.append((self._time_us + DELAY_US, transmit, data))
        elif self._passes():
            transmit(data)

    def hear(self, link: Link, messages: list[Received]) -> list[Received]:
        """Give those of the messages that come through at once."""
        if self.kind is FailureType.GARBAGE:
            return []
        if self.kind is FailureType.DELAYED:
            due_us = self._time_us + DELAY_US
            self._in.extend((due_us, link, received) for received in messages)
            return []
        return [received for received in messages if self._passes()]

    def _passes(self) -> bool:
        if self.kind is not FailureType.SLOW:
            return True
        self._count += 1
        return self._count % SLOWER == 0
