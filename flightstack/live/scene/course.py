"""Draw where things are: the gates, the path, the vehicle, what it is told and what it does."""

import numpy as np
from numpy.typing import NDArray

from flightstack.live.scene.recording import LiveRecording, lines
from flightstack.live.scene.track import FollowedTrack, boot_us, sound_decisions
from flightstack.logs.columns.log import Log
from flightstack.logs.flight.course import CourseGate, find_gates, gate_outline

PATH_PERIOD_US = 100_000
PATH, FLOWN, COMMANDED, GATES = (90, 170, 255), (60, 120, 255), (255, 180, 40), (235, 110, 40)
GATE_RADIUS_M, PATH_RADIUS_M, ARROW_RADIUS_M = 0.06, 0.02, 0.03

Floats = NDArray[np.float64]
Numbers = NDArray[np.int64]


class CourseDrawing:
    """The course around one vehicle, piece after piece; north, east, down in m."""

    def __init__(self, recording: LiveRecording, track: FollowedTrack) -> None:
        self._recording = recording
        self._track = track
        self._gates: dict[int, CourseGate] = {}
        self._last: Floats | None = None  # end of the path
        self._last_us = -PATH_PERIOD_US
        recording.always("world", recording.rerun.ViewCoordinates.FRD)

    def draw(self, log: Log) -> None:
        """Draw a piece."""
        self._draw_gates(log)
        places = self._track.of_vehicle(log, "LOCAL_POSITION_NED")
        times_us = boot_us(places)
        position, velocity = self._track.motion_at(times_us)
        self._draw_path(times_us, position)
        self._arrows("flown", times_us, position, velocity, FLOWN)
        decisions = sound_decisions(log)
        start, _ = self._track.motion_at(decisions.stamp_us)
        yaw = self._track.angles_at(decisions.stamp_us)[:, 2]
        commanded = _turned(decisions.command, yaw)
        self._arrows("commanded", decisions.stamp_us, start, commanded, COMMANDED)

    def _draw_gates(self, log: Log) -> None:
        new = {gate.index: gate for gate in find_gates(log)}
        if not new.keys() - self._gates.keys():
            return
        self._gates |= new
        gates = [self._gates[index] for index in sorted(self._gates)]
        drawn = self._recording.rerun.LineStrips3D(
            lines([gate_outline(gate) for gate in gates]),
            colors=[GATES],
            radii=GATE_RADIUS_M,
            labels=[str(gate.index + 1) for gate in gates],
        )
        self._recording.always("world/gates", drawn)

    def _draw_path(self, times_us: Numbers, position: Floats) -> None:
        strips, ends_us = [], []
        for at_us, place in zip(times_us.tolist(), position, strict=True):
            if at_us - self._last_us < PATH_PERIOD_US or not np.isfinite(place).all():
                continue
            if self._last is not None:
                strips.append(np.stack([self._last, place]))
                ends_us.append(at_us)
            self._last, self._last_us = place, at_us
        if strips:
            self._recording.always(
                "world/path",
                self._recording.rerun.LineStrips3D.from_fields(
                    colors=[PATH], radii=[PATH_RADIUS_M]
                ),
            )
            columns = self._recording.rerun.LineStrips3D.columns(strips=lines(strips))
            self._recording.columns("world/path", np.array(ends_us), columns)

    def _arrows(
        self, name: str, times_us: Numbers, origins: Floats, vectors: Floats, colour: object
    ) -> None:
        known = np.isfinite(origins).all(axis=1) & np.isfinite(vectors).all(axis=1)
        if not known.any():
            return
        arrows = self._recording.rerun.Arrows3D
        path = f"world/{name}"
        self._recording.always(path, arrows.from_fields(colors=[colour], radii=[ARROW_RADIUS_M]))
        columns = arrows.columns(vectors=vectors[known], origins=origins[known])
        self._recording.columns(path, times_us[known], columns)


def _turned(command: Floats, yaw: Floats) -> Floats:
    """Return commands (n, 4), level with the horizon, as velocities NED, (n, 3)."""
    forward, right, down = command[:, 0], command[:, 1], command[:, 2]
    north = np.cos(yaw) * forward - np.sin(yaw) * right
    east = np.sin(yaw) * forward + np.cos(yaw) * right
    return np.stack([north, east, down], axis=1)
