"""The recording that a viewer shows: what rerun is told, and the bytes that come of it."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flightstack.libraries import load_library

APPLICATION, TIMELINE = "flightstack", "vehicle_time"
EXTRA = "live"

Numbers = NDArray[np.int64]
Array = NDArray[Any]


class LiveRecording:
    """One flight. Times are us of vehicle time."""

    def __init__(self, blueprint: Any, *, name: str) -> None:
        self.rerun = load_library("rerun", EXTRA)
        self._stream = self.rerun.RecordingStream(APPLICATION)
        self._bytes = self._stream.binary_stream()
        self._stream.set_log_tick_enabled(False)
        self._stream.set_log_time_enabled(False)
        self._stream.send_recording_name(name)
        self._stream.send_blueprint(blueprint)

    def columns(self, path: str, times_us: Numbers, columns: Any) -> None:
        """Log rows of one entity, one a time."""
        times = self.rerun.TimeColumn(TIMELINE, duration=times_us * 1e-6)
        self._stream.send_columns(path, [times], columns)

    def series(self, path: str, times_us: Numbers, values: Array) -> None:
        """Log a line over time."""
        if len(times_us):
            scalars = self.rerun.Scalars.columns(scalars=np.asarray(values, dtype=np.float64))
            self.columns(path, times_us, scalars)

    def text(self, path: str, time_us: int, text: str, level: str = "INFO") -> None:
        """Log a line of text."""
        self.at(path, time_us, self.rerun.TextLog(text, level=level))

    def at(self, path: str, time_us: int, what: Any) -> None:
        """Log something at a time."""
        self._stream.set_time(TIMELINE, duration=time_us * 1e-6)
        self._stream.log(path, what)

    def always(self, path: str, what: Any) -> None:
        """Log something that holds at all times."""
        self._stream.log(path, what, static=True)

    def take(self) -> bytes:
        """Return the bytes that came since the last call: a piece of an .rrd file."""
        return bytes(self._bytes.read() or b"")


def lines(points: Sequence[Array]) -> list[Array]:
    """Return polylines as rerun takes them, single precision."""
    return [np.asarray(each, dtype=np.float32) for each in points]
