"""Draw a flight, piece by piece, into one recording."""

import numpy as np

from flightstack.live.scene.blueprint import make_blueprint
from flightstack.live.scene.course import CourseDrawing
from flightstack.live.scene.recording import LiveRecording
from flightstack.live.scene.sight import Rgb, SightDrawing
from flightstack.live.scene.telemetry import TelemetryDrawing
from flightstack.live.scene.track import FollowedTrack
from flightstack.logs.columns.log import Log
from flightstack.perception.gate_detector import GateDetector


class FlightDrawing:
    """All that is drawn of one vehicle."""

    def __init__(self, name: str, system: int | None, detector: GateDetector | None) -> None:
        self.track = FollowedTrack(system)
        self._recording = LiveRecording(make_blueprint(), name=name)
        self._telemetry = TelemetryDrawing(self._recording, self.track)
        self._course = CourseDrawing(self._recording, self.track)
        self._sight = SightDrawing(self._recording, self.track, detector)

    def draw(self, log: Log) -> None:
        """Draw the next packets."""
        with np.errstate(all="ignore"):  # what is said may be NaN, and worse
            self.track.learn(log)
            self._telemetry.draw(log)
            self._course.draw(log)

    def draw_image(self, stamp_us: int, rgb: Rgb) -> None:
        """Draw the next image, (H, W, 3) RGB."""
        with np.errstate(all="ignore"):
            self._sight.draw(stamp_us, rgb)

    def take(self) -> bytes:
        """Return what came since the last call: a piece of an .rrd file."""
        return self._recording.take()
