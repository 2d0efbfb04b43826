"""A stretch of network between vehicle and companion on which every datagram takes its own time."""

import heapq
import itertools
import select
import socket
import time

import numpy as np

from tests.wire.proxy import DATAGRAM_BYTES, Proxy


class JitteringProxy(Proxy):
    """Delay each datagram, either way, by a time drawn evenly from a range; they may overtake."""

    def __init__(self, companion_port: int, *, low_s: float, high_s: float, seed: int = 0) -> None:
        super().__init__(companion_port)
        self._range_s = (low_s, high_s)
        self._rng = np.random.default_rng(seed)
        self._due: list[tuple[float, int, socket.socket, bytes]] = []
        self._count = itertools.count()

    def _run(self) -> None:
        while not self._stop.is_set():
            wait_s = min(0.1, self._due[0][0] - time.monotonic()) if self._due else 0.1
            ends = [self._vehicle_side, self._companion_side]
            for end in select.select(ends, [], [], max(0.0, wait_s))[0]:
                datagram, sender = end.recvfrom(DATAGRAM_BYTES)
                if end is self._vehicle_side:
                    self._vehicle = sender
                other = ends[1 - ends.index(end)]
                due_s = time.monotonic() + self._rng.uniform(*self._range_s)
                heapq.heappush(self._due, (due_s, next(self._count), other, datagram))
            while self._due and self._due[0][0] <= time.monotonic():
                _, _, end, datagram = heapq.heappop(self._due)
                target = self._vehicle if end is self._vehicle_side else self._companion
                if target is not None:
                    end.sendto(datagram, target)
