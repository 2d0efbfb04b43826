"""Say by our clock when a stream's pictures left, from the stream's own stamps.

A stream counts its own time, from anywhere. The picture that came quickest tells best how its clock
and ours lie; what others took longer is the network's jitter, and taken off. What the quickest took
is not seen from here: `--camera-latency-s` is for that.
"""

from collections import deque

WINDOW_S = (
    30.0  # of pictures that are compared: long enough for a quick one, short for two quartzes
)
MAX_DELAY_S = 1.0  # behind the quickest: the stream's clock has jumped


class StreamClock:
    """Take each picture's stamp and arrival, in order."""

    def __init__(self) -> None:
        # Of the window, those that no later one has undercut: arrival, arrival minus stamp; s.
        self._quickest: deque[tuple[float, float]] = deque()

    def left_s(self, stamp_s: float, received_s: float) -> float:
        """Return when a picture left, by our clock; never after it was received."""
        offset_s = received_s - stamp_s
        if self._quickest and offset_s - self._quickest[0][1] > MAX_DELAY_S:
            self._quickest.clear()
        while self._quickest and self._quickest[-1][1] >= offset_s:
            self._quickest.pop()
        self._quickest.append((received_s, offset_s))
        while received_s - self._quickest[0][0] > WINDOW_S:
            self._quickest.popleft()
        return stamp_s + self._quickest[0][1]
