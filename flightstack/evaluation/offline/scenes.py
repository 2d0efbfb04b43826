"""Images that ought to raise uncertainty, beside plain ones: what is ambiguous, or unseen.

Plain scenes and their spoiled copies share gates, attitude and daylight, image by image, so that
nothing but the spoiling tells them apart.
"""

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from flightstack.errors import UsageError
from flightstack.training.data.gate_views import PARKED_NED, place
from sitl import (
    GROUND_TEXTURES,
    Camera,
    Colour,
    Gate,
    Look,
    Quaternion,
    Scenery,
    Vector3,
    at_dusk,
    blurred,
    draw_look,
    quaternion_from_euler,
    wrap_pi,
)

PLAIN, DOUBLE_GATE, NO_GATE = "plain", "double gate", "no gate"
FOG, BLUR = "fog", "blur"
TILT_RAD = math.radians(8.0)  # +- roll and pitch, as in steady flight
HEIGHT_M = (2.0, 4.0)
RANGE_M = (2.0, 6.0)
AZIMUTH_RAD, ELEVATION_RAD = math.radians(20.0), math.radians(12.0)  # +-
APART_RAD = (math.radians(15.0), math.radians(28.0))  # of each of two gates from straight ahead
GATE_YAW_STD_RAD = math.radians(20.0)
FOG_CLEAR = (0.06, 0.25)  # of the contrast that is left; at 6 m `strong` has 0.14 and more
DARKNESS = (0.04, 0.15)  # of the daylight
BLUR_STD_PX = (2.5, 4.0)  # training knows up to 1
UNSEEN_GATES: tuple[Colour, ...] = ((0.1, 0.7, 0.2), (0.1, 0.3, 0.9), (0.9, 0.9, 0.9))

Spoil = Callable[[np.random.Generator, Look], Look]


def no_change(rng: np.random.Generator, look: Look) -> Look:  # noqa: ARG001
    """Leave the day as it is."""
    return look


def darkness(rng: np.random.Generator, look: Look) -> Look:
    """Let the night fall."""
    return at_dusk(look, float(rng.uniform(*DARKNESS)))


def unseen_textures(rng: np.random.Generator, look: Look) -> Look:
    """Paint gates and ground as training never does."""
    light, dark = rng.uniform(0.3, 1.0, 3), rng.uniform(0.0, 0.3, 3)
    return replace(
        look,
        gate_colour=UNSEEN_GATES[int(rng.integers(len(UNSEEN_GATES)))],
        ground_texture=GROUND_TEXTURES + int(rng.integers(GROUND_TEXTURES)),
        ground_scale_m=float(rng.uniform(1.0, 3.0)),
        ground_light=(float(light[0]), float(light[1]), float(light[2])),
        ground_dark=(float(dark[0]), float(dark[1]), float(dark[2])),
    )


PLAIN_SCENERY = Scenery()
SPOILS: dict[str, Spoil] = {
    PLAIN: no_change,
    DOUBLE_GATE: no_change,
    NO_GATE: no_change,
    FOG: no_change,  # of the image, as the next but one
    "darkness": darkness,
    BLUR: no_change,
    "unseen textures": unseen_textures,
}


def render_scene(
    kind: str, count: int, *, seed: int, scenery: Scenery = PLAIN_SCENERY
) -> NDArray[np.uint8]:
    """Render images (count, 64, 64, 3) of one kind of SPOILS; raises UsageError for another."""
    if kind not in SPOILS:
        raise UsageError(f"unknown scene {kind!r}: choose one of {', '.join(SPOILS)}")
    parked = Gate(index=0, centre_ned=PARKED_NED, yaw_rad=0.0, shape=scenery.gate)
    look = draw_look(np.random.default_rng(0), scenery)
    camera = Camera((parked, parked), look, field_of_view_deg=scenery.field_of_view_deg)
    try:
        return np.stack([_render(camera, kind, [seed, k], scenery) for k in range(count)])
    finally:
        camera.close()


def _render(camera: Camera, kind: str, seeds: list[int], scenery: Scenery) -> NDArray[np.uint8]:
    rng, spoiling = np.random.default_rng(seeds), np.random.default_rng([*seeds, 1])
    position = (0.0, 0.0, -float(rng.uniform(*HEIGHT_M)))
    roll, pitch = (float(rng.uniform(-TILT_RAD, TILT_RAD)) for _ in range(2))
    heading = float(rng.uniform(-math.pi, math.pi))
    attitude = quaternion_from_euler(roll, pitch, heading)
    camera.set_look(SPOILS[kind](spoiling, draw_look(rng, scenery)))
    camera.place_gates(_gates(rng, kind, position, attitude, heading))
    image = camera.render(position, attitude)
    if kind == FOG:
        return _veil(image, camera.look, float(spoiling.uniform(*FOG_CLEAR)))
    if kind == BLUR:
        return blurred(image, float(spoiling.uniform(*BLUR_STD_PX)))
    return image


def _veil(image: NDArray[np.uint8], look: Look, clear: float) -> NDArray[np.uint8]:
    """Let the horizon's colour cover all but a share `clear` of what is seen."""
    fog = 255.0 * np.array(look.sky_horizon)
    return np.asarray(np.rint(fog + (image - fog) * clear), dtype=np.uint8)


def _gates(
    rng: np.random.Generator, kind: str, position: Vector3, attitude: Quaternion, heading: float
) -> tuple[Gate, Gate]:
    """One gate ahead, two equally near on either side, or none."""
    range_m, yaw = float(rng.uniform(*RANGE_M)), float(rng.normal(0.0, GATE_YAW_STD_RAD))
    azimuth = float(rng.uniform(-AZIMUTH_RAD, AZIMUTH_RAD))
    elevation = float(rng.uniform(-ELEVATION_RAD, ELEVATION_RAD))
    parked = Gate(index=0, centre_ned=PARKED_NED, yaw_rad=0.0)

    def gate(azimuth: float, yaw: float) -> Gate:
        centre = place(position, attitude, range_m, azimuth, elevation)
        return Gate(index=0, centre_ned=centre, yaw_rad=wrap_pi(heading + yaw))

    if kind == NO_GATE:
        return parked, parked
    if kind == DOUBLE_GATE:
        apart = float(rng.uniform(*APART_RAD))
        return gate(-apart, -apart), gate(apart, apart)
    return gate(azimuth, yaw), parked
