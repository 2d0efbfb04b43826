"""Draw what was flown, commanded, doubted and said, as lines over time and texts."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from flightstack.live.scene.recording import LiveRecording
from flightstack.live.scene.track import FollowedTrack, boot_us, sound_decisions
from flightstack.logs.columns.log import Log
from flightstack.logs.flight.decisions import LINEAR, PARTS, Decisions
from flightstack.logs.flight.modes import mode_name
from flightstack.logs.flight.texts import status_texts

AXES = ("forward", "right", "down", "yaw_rate")
LEVELS: Mapping[int, str] = {
    **dict.fromkeys(range(3), "CRITICAL"),
    3: "ERROR",
    4: "WARN",
    **dict.fromkeys((5, 6), "INFO"),
    7: "DEBUG",
}

Floats = NDArray[np.float64]


class TelemetryDrawing:
    """Lines and texts of one vehicle, piece after piece."""

    def __init__(self, recording: LiveRecording, track: FollowedTrack) -> None:
        self._recording = recording
        self._track = track
        self._mode = ""

    def draw(self, log: Log) -> None:
        """Draw a piece."""
        self._flown(log)
        self._decided(sound_decisions(log))
        self._modes(log)
        for text in status_texts(log):
            at_us = int(self._track.vehicle_us(np.array([text.time_us]))[0])
            level = LEVELS.get(text.severity, "INFO")
            self._recording.text("texts", at_us, f"{text.source} {text.text}", level)

    def _flown(self, log: Log) -> None:
        places = self._track.of_vehicle(log, "LOCAL_POSITION_NED")
        times_us = boot_us(places)
        yaw = self._track.angles_at(times_us)[:, 2]
        north, east, down = (places[name].astype(np.float64) for name in ("vx", "vy", "vz"))
        forward = np.cos(yaw) * north + np.sin(yaw) * east
        right = np.cos(yaw) * east - np.sin(yaw) * north
        for name, values in zip(AXES, (forward, right, down), strict=False):
            self._recording.series(f"velocity/{name}/flown", times_us, values)
        turning = self._track.of_vehicle(log, "ATTITUDE")
        rate = turning["yawspeed"].astype(np.float64)
        self._recording.series(f"velocity/{AXES[3]}/flown", boot_us(turning), rate)

    def _decided(self, decisions: Decisions) -> None:
        for column, name in enumerate(AXES):
            values = decisions.command[:, column]
            self._recording.series(f"velocity/{name}/commanded", decisions.stamp_us, values)
        for part in PARTS:
            std = getattr(decisions, f"{part}_std")[:, LINEAR]
            length = np.linalg.norm(std, axis=1)
            self._recording.series(f"uncertainty/{part}", decisions.stamp_us, length)

    def _modes(self, log: Log) -> None:
        beats = self._track.of_vehicle(log, "HEARTBEAT")
        columns = [beats[n].tolist() for n in ("autopilot", "type", "base_mode", "custom_mode")]
        times = self._track.vehicle_us(beats.time_us).tolist()
        for at_us, *told in zip(times, *columns, strict=True):
            mode = mode_name(*told)
            if mode != self._mode:
                self._mode = mode
                self._recording.text("texts", at_us, f"mode {mode}")
