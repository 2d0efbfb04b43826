"""Draw what the camera saw, and the gates that a detector finds in it, each with its covariance."""

import cv2
import numpy as np
from numpy.typing import NDArray

from flightstack.frames import rotation_ned_frd
from flightstack.live.scene.recording import LiveRecording
from flightstack.live.scene.track import FollowedTrack
from flightstack.perception.gate_detector import GateDetector
from flightstack.records import GateDetections

SIDE = 64  # pixels of a detector's image
SIGMAS = 2.0  # of an ellipsoid's half axes
SEEN = (80, 220, 120)
DOT_PIXELS = 1.5
FAST = (cv2.IMWRITE_PNG_COMPRESSION, 1)

Rgb = NDArray[np.uint8]


class SightDrawing:
    """Images, and what a detector of our own sees in them; the companion's is not asked."""

    def __init__(
        self, recording: LiveRecording, track: FollowedTrack, detector: GateDetector | None
    ) -> None:
        self._recording = recording
        self._track = track
        self._detector = detector

    def draw(self, stamp_us: int, rgb: Rgb) -> None:
        """Draw one image."""
        bgr = cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR)
        _, coded = cv2.imencode(".png", bgr, FAST)
        image = self._recording.rerun.EncodedImage(contents=coded.tobytes(), media_type="image/png")
        self._recording.at("camera/image", stamp_us, image)
        if self._detector is not None:
            small = cv2.resize(rgb, (SIDE, SIDE), interpolation=cv2.INTER_AREA)
            found = self._detector.detect(np.asarray(small, np.uint8))
            self._draw_in_image(stamp_us, found, rgb.shape[1], rgb.shape[0])
            self._draw_in_world(stamp_us, found)

    def _draw_in_image(self, stamp_us: int, found: GateDetections, width: int, height: int) -> None:
        ahead, right, down = found.position_frd.T
        at = np.stack([(1 + right / ahead) * width / 2, (1 + down / ahead) * height / 2], axis=1)
        labels = [f"{score:.0%}" for score in found.score.tolist()]
        points = self._recording.rerun.Points2D(
            at, colors=[SEEN], radii=DOT_PIXELS, labels=labels, draw_order=10.0
        )
        self._recording.at("camera/seen", stamp_us, points)

    def _draw_in_world(self, stamp_us: int, found: GateDetections) -> None:
        now = np.array([stamp_us])
        position = self._track.motion_at(now)[0][0]
        angles = self._track.angles_at(now)[0]
        if not np.isfinite([*position, *angles]).all():
            return
        turn = rotation_ned_frd(angles)
        centres = position + found.position_frd @ turn.T
        covariance = turn @ found.covariance_frd @ turn.T
        variances, axes = np.linalg.eigh(covariance)
        half = SIGMAS * np.sqrt(np.maximum(variances, 0.0))
        ellipsoids = self._recording.rerun.Ellipsoids3D(
            centers=centres,
            half_sizes=half,
            rotation_axis_angles=[self._rotation(each) for each in axes],
            colors=[SEEN],
        )
        self._recording.at("world/seen", stamp_us, ellipsoids)

    def _rotation(self, axes: NDArray[np.float64]) -> object:
        """Return principal axes, the columns of (3, 3), as a rotation about one axis."""
        right_handed = axes * np.array([1.0, 1.0, np.sign(np.linalg.det(axes))])
        vector = cv2.Rodrigues(right_handed)[0][:, 0]
        angle = float(np.linalg.norm(vector))
        axis = vector / angle if angle > 0 else np.array([1.0, 0.0, 0.0])
        return self._recording.rerun.RotationAxisAngle(axis=axis, angle=angle)
