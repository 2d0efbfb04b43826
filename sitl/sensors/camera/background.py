"""Ground and sky behind the gates, one ray per pixel: cheaper and finer than textured polygons.

pybullet's software renderer spends most of its time on a ground that fills half the image; one
vectorised look-up in a tileable texture gives the same ground, with haze, in a tenth of a
millisecond.
"""

import math
from functools import cache

import numpy as np
from numpy.typing import NDArray

from sitl.sensors.camera.look import TEXTURE_SIZE, Colour, Look, make_texture
from sitl.sensors.camera.texture_files import read_texture

CLOUD_HEIGHT_M = 60.0
CLOUD_TILE_M = 300.0
MIN_SLOPE = 0.02  # rays flatter than this see haze only
TEXTURE_MASK = TEXTURE_SIZE - 1  # its size is a power of two


class Background:
    """Draw the ground plane and the sky for one camera geometry."""

    def __init__(self, rays_frd: NDArray[np.float32]) -> None:
        """Keep the rays, of shape (3, H * W), FRD with unit forward component."""
        self._rays = rays_frd
        self._norms = np.linalg.norm(rays_frd, axis=0)

    def draw(
        self, rotation_ned_frd: NDArray[np.float32], position_ned: NDArray[np.float32], look: Look
    ) -> NDArray[np.float32]:
        """Colours in 0..255 with shape (3, H * W), before any gate is drawn."""
        rays = rotation_ned_frd @ self._rays  # (3, P) NED
        slope = rays[2] / self._norms  # sine of the angle below the horizon
        altitude = np.float32(max(0.05, -float(position_ned[2])))
        is_ground = slope > 0.0
        steep = np.maximum(np.abs(slope), MIN_SLOPE) * self._norms
        reach = np.where(is_ground, altitude, CLOUD_HEIGHT_M) / steep
        north = position_ned[0] + rays[0] * reach
        east = position_ned[1] + rays[1] * reach
        texture = _look_up(north, east, is_ground, look)

        dark, light = _colour(look.ground_dark), _colour(look.ground_light)
        horizon, zenith = _colour(look.sky_horizon), _colour(look.sky_zenith)
        ground = dark + (light - dark) * texture
        up = np.clip(-slope, 0.0, 1.0)
        sky = horizon + (zenith - horizon) * np.sqrt(up)
        sky += np.float32(look.cloudiness) * (texture - np.float32(0.5)) * np.minimum(up * 4.0, 1.0)
        clear = np.exp(-reach * self._norms / np.float32(look.haze_m))
        colours = np.where(is_ground, horizon + (ground - horizon) * clear, sky)
        return np.asarray(np.clip(colours, 0.0, 1.0) * np.float32(255.0))


def _look_up(
    north: NDArray[np.float32], east: NDArray[np.float32], is_ground: NDArray[np.bool_], look: Look
) -> NDArray[np.float32]:
    """Texture (P,) where rays meet ground or clouds."""
    scale = np.where(
        is_ground,
        TEXTURE_SIZE / np.float32(look.ground_scale_m),
        TEXTURE_SIZE / np.float32(CLOUD_TILE_M),
    )
    cos_turn, sin_turn = math.cos(look.ground_turn_rad), math.sin(look.ground_turn_rad)
    column = ((cos_turn * north + sin_turn * east) * scale).astype(np.int32) & TEXTURE_MASK
    row = ((cos_turn * east - sin_turn * north) * scale).astype(np.int32) & TEXTURE_MASK
    at = row * TEXTURE_SIZE + column
    noise = _texture(look.ground_texture).take(at)
    if not look.ground_picture:
        return noise
    return np.where(is_ground, read_texture(look.ground_picture).take(at), noise)


def _colour(colour: Colour) -> NDArray[np.float32]:
    return np.array(colour, dtype=np.float32)[:, None]


@cache
def _texture(index: int) -> NDArray[np.float32]:
    return make_texture(index)
