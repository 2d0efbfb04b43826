"""Scenes: an image, and where the gates are that can be seen in it.

A label has the gate's centre in pixels, its distance, and the angle under which it is seen: of its
normal, clockwise from the line of sight, modulo pi, since a gate looks the same from behind.
"""

import math

import cv2
import numpy as np
from jaxtyping import Float32
from numpy.typing import NDArray

from flightstack.arrays import SmallRgb
from flightstack.training.data.gate_views import PARKED_NED, place
from flightstack.training.scene_recipe import SceneRecipe, Span
from sitl import (
    Camera,
    Gate,
    Look,
    Quaternion,
    Vector3,
    at_dusk,
    draw_look,
    euler_from_quaternion,
    in_fog,
    quaternion_from_euler,
    rotate,
    wrap_pi,
)

IMAGE_PX = 64
FARTHEST_M = 15.0  # gates beyond are nobody's concern
NEAREST_M = 0.45  # the frame is out of view
TRIES = 40
SceneLabels = Float32[NDArray[np.float32], "G 4"]  # u, v (px), distance (m), seen angle (rad)


class SceneRenderer:
    """Draws scenes, one after another."""

    def __init__(self, recipe: SceneRecipe) -> None:
        self._recipe = recipe
        self._parked = tuple(
            Gate(index=i, centre_ned=PARKED_NED, yaw_rad=0.0, shape=recipe.scenery.gate)
            for i in range(recipe.most_gates)
        )
        self._camera = Camera(self._parked, draw_look(np.random.default_rng(0), recipe.scenery))
        self._lowest_m = recipe.scenery.gate.outer_m / 2.0  # of a centre above ground

    def close(self) -> None:
        """Free the renderer."""
        self._camera.close()

    def draw(self, rng: np.random.Generator) -> tuple[SmallRgb, SceneLabels]:
        """One image, and the gates in it."""
        recipe = self._recipe
        tilts = rng.uniform(-recipe.tilt_rad, recipe.tilt_rad, 2)
        yaw = float(rng.uniform(-math.pi, math.pi))
        attitude = quaternion_from_euler(float(tilts[0]), float(tilts[1]), yaw)
        position = (0.0, 0.0, -float(rng.uniform(*recipe.height_m)))
        gates = self._arrange(rng, position, attitude)
        self._camera.place_gates((*gates, *self._parked[len(gates) :]))
        self._camera.set_look(self._draw_look(rng))
        image = self._spoil(rng, self._camera.render(position, attitude))
        return image, labels_of(gates, position, attitude)

    def _arrange(
        self, rng: np.random.Generator, position: Vector3, attitude: Quaternion
    ) -> tuple[Gate, ...]:
        recipe = self._recipe
        kind = rng.random()
        if kind < recipe.empty_share:
            return ()
        nearest_m = _log_uniform(rng, recipe.range_m)
        first = self._draw_gate(rng, position, attitude, nearest_m)
        if kind < recipe.empty_share + recipe.pair_share:
            gates = [first, self._beside(first, rng)]
            further = int(rng.integers(3))
        elif kind < recipe.empty_share + recipe.pair_share + recipe.crowd_share:
            gates, further = [first], int(rng.integers(2, recipe.most_gates))
        else:
            gates, further = [first], int(rng.integers(3))
        for _ in range(min(further, recipe.most_gates - len(gates))):
            distance_m = nearest_m + float(rng.uniform(1.2, 10.0))
            gates.append(self._draw_gate(rng, position, attitude, distance_m))
        return tuple(gates)

    def _draw_gate(
        self, rng: np.random.Generator, position: Vector3, attitude: Quaternion, distance_m: float
    ) -> Gate:
        recipe = self._recipe
        for _ in range(TRIES):
            azimuth = float(rng.uniform(-recipe.azimuth_rad, recipe.azimuth_rad))
            elevation = float(rng.uniform(-recipe.elevation_rad, recipe.elevation_rad))
            centre = place(position, attitude, distance_m, azimuth, elevation)
            if centre[2] < -self._lowest_m:
                break
        else:
            centre = (centre[0], centre[1], -self._lowest_m)
        if rng.random() < recipe.gate_yaw_uniform_share:
            turn = float(rng.uniform(-math.pi, math.pi))
        else:
            turn = float(rng.normal(0.0, recipe.gate_yaw_std_rad))
        heading = euler_from_quaternion(attitude)[2]
        return Gate(index=0, centre_ned=centre, yaw_rad=wrap_pi(heading + turn))

    def _beside(self, gate: Gate, rng: np.random.Generator) -> Gate:
        """Put a twin to the left or right."""
        gap_m = float(rng.uniform(*self._recipe.pair_gap_m))
        side = gap_m if rng.random() < 0.5 else -gap_m
        north, east, down = gate.centre_ned
        centre = (
            north - side * math.sin(gate.yaw_rad),
            east + side * math.cos(gate.yaw_rad),
            min(down + float(rng.normal(0.0, 0.15)), -self._lowest_m),
        )
        yaw = gate.yaw_rad + float(rng.normal(0.0, 0.1))
        return Gate(index=0, centre_ned=centre, yaw_rad=wrap_pi(yaw))

    def _draw_look(self, rng: np.random.Generator) -> Look:
        recipe = self._recipe
        look = draw_look(rng, recipe.scenery)
        if rng.random() < recipe.dusk_share:
            look = at_dusk(look, _log_uniform(rng, recipe.daylight))
        if rng.random() < recipe.fog_share:
            look = in_fog(look, _log_uniform(rng, recipe.visibility_m))
        return look

    def _spoil(self, rng: np.random.Generator, image: SmallRgb) -> SmallRgb:
        recipe = self._recipe
        blur = _one_of(
            rng,
            (recipe.bad_blur_share, recipe.bad_blur_std_px),
            (recipe.blur_share, recipe.blur_std_px),
        )
        if blur > 0.0:
            image = np.asarray(cv2.GaussianBlur(image, (0, 0), blur), dtype=np.uint8)
        noise_std = _one_of(
            rng,
            (recipe.bad_noise_share, recipe.bad_noise_std),
            (recipe.noise_share, recipe.noise_std),
        )
        if noise_std > 0.0:
            noise = rng.standard_normal(image.shape, dtype=np.float32) * np.float32(noise_std)
            image = np.clip(np.rint(image + noise), 0, 255).astype(np.uint8)
        return image


def labels_of(gates: tuple[Gate, ...], position: Vector3, attitude: Quaternion) -> SceneLabels:
    """Say where the gates are whose centres are in the image, the nearest first."""
    w, x, y, z = attitude
    heading = euler_from_quaternion(attitude)[2]
    labels = []
    for gate in gates:
        offset = tuple(c - p for c, p in zip(gate.centre_ned, position, strict=True))
        ahead, right, down = rotate((w, -x, -y, -z), (offset[0], offset[1], offset[2]))
        distance_m = math.sqrt(ahead * ahead + right * right + down * down)
        if ahead <= 0.0 or not NEAREST_M < distance_m < FARTHEST_M:
            continue
        u, v = ((tangent + 1.0) / 2.0 * IMAGE_PX for tangent in (right / ahead, down / ahead))
        if 0.0 <= u < IMAGE_PX and 0.0 <= v < IMAGE_PX:
            seen = gate.yaw_rad - heading - math.atan2(right, ahead)
            labels.append((u, v, distance_m, math.remainder(seen, math.pi)))
    return np.array(sorted(labels, key=lambda label: label[2]), np.float32).reshape(-1, 4)


def _log_uniform(rng: np.random.Generator, span: Span) -> float:
    return math.exp(float(rng.uniform(math.log(span[0]), math.log(span[1]))))


def _one_of(rng: np.random.Generator, *choices: tuple[float, Span]) -> float:
    """Draw from the first span whose share is met, 0 from none."""
    drawn = rng.random()
    for share, span in choices:
        if drawn < share:
            return float(rng.uniform(*span))
        drawn -= share
    return 0.0
