"""Perception data: single images of gates with the pose of the nearest one (`LABELS`).

Every image has a look, an attitude and a height of its own. The labelled gate's direction is
drawn over the field of view, and farther gates may stand behind it as distractors, as on a course.
"""

import math

import cv2
import numpy as np
from jaxtyping import Float32
from numpy.typing import NDArray

from flightstack.arrays import SmallRgb
from flightstack.training.recipe import ViewRecipe
from sitl import (
    Camera,
    Gate,
    Quaternion,
    Vector3,
    draw_look,
    euler_from_quaternion,
    in_fog,
    quaternion_from_euler,
    rotate,
    wrap_pi,
)

PARKED_NED = (0.0, 0.0, 1000.0)  # where gates wait that are not in the image


class ViewRenderer:
    """Draw labelled views one after another."""

    def __init__(self, recipe: ViewRecipe) -> None:
        self._recipe = recipe
        scenery = recipe.scenery
        parked = tuple(
            Gate(index=i, centre_ned=PARKED_NED, yaw_rad=0.0, shape=scenery.gate)
            for i in range(1 + recipe.most_distractors)
        )
        look = draw_look(np.random.default_rng(0), scenery)
        self._camera = Camera(parked, look, field_of_view_deg=scenery.field_of_view_deg)
        self._lowest_m = scenery.gate.outer_m / 2.0  # of a centre above ground
        self._parked = parked

    def close(self) -> None:
        """Free the renderer."""
        self._camera.close()

    def draw(self, rng: np.random.Generator) -> tuple[SmallRgb, Float32[NDArray[np.float32], "4"]]:
        """One image and its label."""
        recipe = self._recipe
        height_m = float(rng.uniform(*recipe.height_m))
        attitude = quaternion_from_euler(
            float(rng.uniform(-recipe.tilt_rad, recipe.tilt_rad)),
            float(rng.uniform(-recipe.tilt_rad, recipe.tilt_rad)),
            float(rng.uniform(-math.pi, math.pi)),
        )
        position = (0.0, 0.0, -height_m)
        target, label = self._draw_target(rng, position, attitude)
        distractors = [
            self._draw_distractor(rng, position, attitude, float(label[0]))
            for _ in range(int(rng.integers(recipe.most_distractors + 1)))
        ]
        parked = self._parked[1 + len(distractors) :]
        self._camera.place_gates((target, *distractors, *parked))
        look = draw_look(rng, recipe.scenery)
        self._camera.set_look(in_fog(look, recipe.fog.draw_visibility_m(rng)))
        return self._spoil(rng, self._camera.render(position, attitude)), label

    def _draw_target(
        self, rng: np.random.Generator, position: Vector3, attitude: Quaternion
    ) -> tuple[Gate, NDArray[np.float32]]:
        recipe = self._recipe
        while True:
            range_m = _draw_range(rng, recipe)
            azimuth = float(rng.uniform(-recipe.azimuth_rad, recipe.azimuth_rad))
            elevation = float(rng.uniform(-recipe.elevation_rad, recipe.elevation_rad))
            centre = place(position, attitude, range_m, azimuth, elevation)
            if -centre[2] > self._lowest_m:
                break
        if rng.random() < recipe.gate_yaw_uniform_share:
            gate_yaw = float(rng.uniform(-recipe.gate_yaw_rad, recipe.gate_yaw_rad))
        else:
            drawn = float(rng.normal(0.0, recipe.gate_yaw_std_rad))
            gate_yaw = max(-recipe.gate_yaw_rad, min(recipe.gate_yaw_rad, drawn))
        heading = euler_from_quaternion(attitude)[2]
        gate = Gate(index=0, centre_ned=centre, yaw_rad=wrap_pi(heading + gate_yaw))
        return gate, np.array([range_m, azimuth, elevation, gate_yaw], dtype=np.float32)

    def _draw_distractor(
        self, rng: np.random.Generator, position: Vector3, attitude: Quaternion, target_m: float
    ) -> Gate:
        recipe = self._recipe
        while True:
            range_m = target_m + float(rng.uniform(*recipe.distractor_gap_m))
            azimuth = float(rng.uniform(-recipe.azimuth_rad, recipe.azimuth_rad))
            elevation = float(rng.uniform(-recipe.elevation_rad, recipe.elevation_rad)) / 2.0
            centre = place(position, attitude, range_m, azimuth, elevation)
            if -centre[2] > self._lowest_m:
                yaw = float(rng.uniform(-math.pi, math.pi))
                return Gate(index=0, centre_ned=centre, yaw_rad=yaw)

    def _spoil(self, rng: np.random.Generator, image: SmallRgb) -> SmallRgb:
        """Blur and add sensor noise to a share of the images."""
        recipe = self._recipe
        if rng.random() < recipe.blur_share:
            std_px = float(rng.uniform(*recipe.blur_std_px))
            image = np.asarray(cv2.GaussianBlur(image, (0, 0), std_px), dtype=np.uint8)
        if rng.random() < recipe.noise_share:
            noise = rng.standard_normal(image.shape, dtype=np.float32)
            noise *= np.float32(rng.uniform(0.0, recipe.noise_std))
            image = np.clip(np.rint(image + noise), 0, 255).astype(np.uint8)
        return image


def _draw_range(rng: np.random.Generator, recipe: ViewRecipe) -> float:
    if recipe.range_uniform:
        return float(rng.uniform(*recipe.range_m))
    return math.exp(float(rng.uniform(*np.log(recipe.range_m))))


def place(
    position: Vector3, attitude: Quaternion, range_m: float, azimuth: float, elevation: float
) -> Vector3:
    """Where a point stands (m, NED) that a camera sees in that direction (body FRD)."""
    ahead = math.cos(elevation)
    ray = (ahead * math.cos(azimuth), ahead * math.sin(azimuth), -math.sin(elevation))
    north, east, down = rotate(attitude, ray)
    return (
        position[0] + range_m * north,
        position[1] + range_m * east,
        position[2] + range_m * down,
    )
