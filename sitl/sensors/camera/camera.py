"""The front camera: a pinhole at the body's origin that looks along its nose and tilts with it."""

import math
from collections.abc import Sequence

import cv2
import numpy as np
import pybullet
from numpy.typing import NDArray

from sitl.frames import flip, rotate, to_bullet_quaternion
from sitl.records.course import Gate
from sitl.records.motion import Quaternion, Vector3
from sitl.records.scenery import FIELD_OF_VIEW_DEG
from sitl.sensors.camera.background import Background
from sitl.sensors.camera.gate_window import GateWindow, Window
from sitl.sensors.camera.look import Look
from sitl.sensors.camera.texture_files import readable

SIZE_PX = 64
SUPERSAMPLING = 2  # gates are drawn finer and averaged, so that thin far bars do not flicker
NO_PICTURE = -1
NEAR_M = 0.05
FAR_M = 60.0


class Camera:
    """Draw gates before ground and sky, in a pybullet client of its own that holds nothing else."""

    def __init__(
        self,
        gates: tuple[Gate, ...],
        look: Look,
        *,
        field_of_view_deg: float = FIELD_OF_VIEW_DEG,
    ) -> None:
        """Put the gates up; raises UsageError where a picture of the look cannot be read."""
        self._client: int = pybullet.connect(pybullet.DIRECT)
        self._fine = SIZE_PX * SUPERSAMPLING
        self._projection = pybullet.computeProjectionMatrixFOV(
            field_of_view_deg, 1.0, NEAR_M, FAR_M
        )
        self._reach = math.tan(math.radians(field_of_view_deg) / 2.0)
        self._window = GateWindow(size_px=self._fine, reach=self._reach, near_m=NEAR_M, far_m=FAR_M)
        self._background = Background(_pixel_rays(SIZE_PX, field_of_view_deg))
        fine_rays = _pixel_rays(self._fine, field_of_view_deg).reshape(3, self._fine, self._fine)
        self._fine_norms = np.linalg.norm(fine_rays, axis=0)
        self._bodies = [(self._add_gate(gate), len(gate.shape.bars())) for gate in gates]
        self._pictures: dict[str, int] = {}
        self.look = look
        self.set_look(look)
        self.place_gates(gates)

    def close(self) -> None:
        """Free the renderer."""
        pybullet.disconnect(self._client)

    def set_look(self, look: Look) -> None:
        """Change light, colours and pictures; raises UsageError where one cannot be read."""
        self.look = look
        picture = self._load(look.gate_picture) if look.gate_picture else NO_PICTURE
        for body, bars in self._bodies:
            for shape in range(bars):
                pybullet.changeVisualShape(
                    body,
                    -1,
                    shapeIndex=shape,
                    rgbaColor=(*look.gate_colour, 1.0),
                    textureUniqueId=picture,
                    physicsClientId=self._client,
                )

    def place_gates(self, gates: tuple[Gate, ...]) -> None:
        """Move the gates; their number and shapes are fixed when the camera is made."""
        self._window.place_gates(gates)
        for (body, _), gate in zip(self._bodies, gates, strict=True):
            half = gate.yaw_rad / 2.0
            pybullet.resetBasePositionAndOrientation(
                body,
                flip(gate.centre_ned),
                to_bullet_quaternion((math.cos(half), 0.0, 0.0, math.sin(half))),
                physicsClientId=self._client,
            )

    def render(self, position_ned: Vector3, q_ned_frd: Quaternion) -> NDArray[np.uint8]:
        """Take an image of shape (SIZE_PX, SIZE_PX, 3), RGB."""
        axes = [
            rotate(q_ned_frd, axis) for axis in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
        ]
        rotation = np.array(axes, dtype=np.float32).T
        position = np.array(position_ned, dtype=np.float32)
        colours = self._background.draw(rotation, position, self.look)
        planes = colours.reshape(3, SIZE_PX, SIZE_PX)  # a colour at a time: long rows are fast
        window = self._window.look(position, rotation)
        if window is not None:
            drawn = self._draw_gates(position_ned, axes[0], axes[2], window)
            *gates, coverage = cv2.split(drawn)
            left, top, right, bottom = (edge // SUPERSAMPLING for edge in window)
            inside = planes[:, top:bottom, left:right]
            inside *= 1.0 - coverage * np.float32(1.0 / 255.0)
            inside += gates
        rgb = cv2.merge(tuple(np.rint(planes).astype(np.uint8)))
        return np.asarray(rgb, dtype=np.uint8)

    def _draw_gates(
        self, position_ned: Vector3, forward_ned: Vector3, down_ned: Vector3, window: Window
    ) -> NDArray[np.uint8]:
        """Colour times coverage, and coverage 0..255 of the gates, in a window: (h, w, 4)."""
        width, height = window.right - window.left, window.bottom - window.top
        eye, forward, down = flip(position_ned), flip(forward_ned), flip(down_ned)
        view = pybullet.computeViewMatrix(
            eye,
            (eye[0] + forward[0], eye[1] + forward[1], eye[2] + forward[2]),
            (-down[0], -down[1], -down[2]),
        )
        _, _, rgba, depth, _ = pybullet.getCameraImage(
            width,
            height,
            view,
            self._project(window),
            lightDirection=self.look.light_nwu,
            lightAmbientCoeff=self.look.ambient,
            lightDiffuseCoeff=self.look.diffuse,
            lightSpecularCoeff=self.look.specular,
            shadow=0,
            renderer=pybullet.ER_TINY_RENDERER,
            flags=pybullet.ER_NO_SEGMENTATION_MASK,
            physicsClientId=self._client,
        )
        pixels = rgba.view(np.uint32)  # one number per pixel: four times fewer to clear
        pixels *= (depth < 1.0)[..., None]  # where nothing was drawn
        if self.look.fog_m < math.inf:
            self._veil(rgba, depth, window)
        size = width // SUPERSAMPLING, height // SUPERSAMPLING
        mean = cv2.resize(rgba, size, interpolation=cv2.INTER_AREA)
        return np.asarray(mean, dtype=np.uint8).reshape(size[1], size[0], 4)

    def _project(self, window: Window) -> Sequence[float]:
        """Return the projection that leads to the same pixels, of a window alone."""
        if window == self._window.whole:
            whole: Sequence[float] = self._projection
            return whole
        per_px = 2.0 / self._fine
        edge_m = NEAR_M * self._reach
        matrix: Sequence[float] = pybullet.computeProjectionMatrix(
            (window.left * per_px - 1.0) * edge_m,
            (window.right * per_px - 1.0) * edge_m,
            (1.0 - window.bottom * per_px) * edge_m,
            (1.0 - window.top * per_px) * edge_m,
            NEAR_M,
            FAR_M,
        )
        return matrix

    def _veil(self, rgba: NDArray[np.uint8], depth: NDArray[np.float32], window: Window) -> None:
        """Let the fog, which has the horizon's colour, cover gates the more the farther they are.

        `depth` is OpenGL's, 0 at NEAR_M to 1 at FAR_M, along the camera's axis.
        """
        drawn = depth < 1.0
        ahead_m = FAR_M * NEAR_M / (FAR_M - (FAR_M - NEAR_M) * depth[drawn])
        norms = self._fine_norms[window.top : window.bottom, window.left : window.right][drawn]
        clear = np.exp(-ahead_m * norms / self.look.fog_m)[:, None]
        fog = 255.0 * np.array(self.look.sky_horizon)
        rgba[drawn, :3] = np.rint(fog + (rgba[drawn, :3] - fog) * clear)

    def _load(self, picture: str) -> int:
        """Give a picture's number in the renderer, which reads it once."""
        if picture not in self._pictures:
            with readable(picture) as path:
                self._pictures[picture] = pybullet.loadTexture(path, physicsClientId=self._client)
        return self._pictures[picture]

    def _add_gate(self, gate: Gate) -> int:
        bars = gate.shape.bars()
        shape = pybullet.createVisualShapeArray(
            shapeTypes=[pybullet.GEOM_BOX] * len(bars),
            halfExtents=[bar.half_extents for bar in bars],
            visualFramePositions=[flip(bar.centre) for bar in bars],
            visualFrameOrientations=[to_bullet_quaternion(bar.q) for bar in bars],
            physicsClientId=self._client,
        )
        body: int = pybullet.createMultiBody(
            baseVisualShapeIndex=shape, physicsClientId=self._client
        )
        return body


def _pixel_rays(size_px: int, field_of_view_deg: float) -> NDArray[np.float32]:
    """Rays through the pixel centres, shape (3, H * W): FRD, unit forward component."""
    reach = math.tan(math.radians(field_of_view_deg) / 2.0)
    steps = ((np.arange(size_px) + 0.5) / size_px * 2.0 - 1.0) * reach
    right, down = np.meshgrid(steps, steps)
    return np.stack([np.ones(right.size), right.ravel(), down.ravel()]).astype(np.float32)
