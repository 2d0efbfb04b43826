"""What the world looks like on one day: light, sky, ground and gate colours, drawn by a seed."""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from sitl.records.scenery import PLAIN, Scenery

GROUND_TEXTURES = 24  # distinct seeded textures to draw from
TEXTURE_SIZE = 256  # texels per side; textures tile
MIN_CONTRAST = 0.02  # that an eye still sees: it defines the visibility

Colour = tuple[float, float, float]  # linear RGB, 0..1


@dataclass(frozen=True, slots=True, kw_only=True)
class Look:
    """Everything that decides how a scene is drawn, apart from where things are."""

    gate_colour: Colour
    ambient: float
    diffuse: float
    specular: float
    light_nwu: tuple[float, float, float]  # towards the light
    sky_zenith: Colour
    sky_horizon: Colour
    cloudiness: float  # 0..1, strength of the clouds' texture
    ground_light: Colour
    ground_dark: Colour
    ground_texture: int  # which of the seeded textures, where there is no picture
    ground_scale_m: float  # side of one tile
    ground_turn_rad: float
    haze_m: float  # distance at which the contrast of the ground has fallen to 1/e
    fog_m: float = math.inf  # and that of the gates
    gate_picture: str = ""  # path; none
    ground_picture: str = ""


def draw_look(rng: np.random.Generator, scenery: Scenery = PLAIN) -> Look:
    """Draw one look: daylight of any colour, any kind of ground, gates of the scenery's colours."""
    brightness = rng.uniform(0.65, 1.1)
    sun_azimuth = rng.uniform(-np.pi, np.pi)
    sun_elevation = rng.uniform(0.35, 1.4)
    light = (
        float(np.cos(sun_azimuth) * np.cos(sun_elevation)),
        float(np.sin(sun_azimuth) * np.cos(sun_elevation)),
        float(np.sin(sun_elevation)),
    )
    zenith = np.array([0.30, 0.50, 0.80]) + rng.uniform(-0.15, 0.15, 3)
    horizon = np.array([0.78, 0.84, 0.90]) + rng.uniform(-0.15, 0.10, 3)
    overcast = rng.uniform(0.0, 1.0)
    zenith = (1.0 - 0.7 * overcast) * zenith + 0.7 * overcast * horizon.mean()
    ground = rng.uniform([0.25, 0.25, 0.18], [0.60, 0.58, 0.50]) * brightness
    contrast = rng.uniform(0.25, 0.8)
    gate = rng.uniform(scenery.gate_colour_low, scenery.gate_colour_high)
    look = Look(
        gate_colour=_colour(gate),
        ambient=float(rng.uniform(0.45, 0.7) * brightness),
        diffuse=float(rng.uniform(0.25, 0.55) * brightness),
        specular=float(rng.uniform(0.0, 0.1)),
        light_nwu=light,
        sky_zenith=_colour(zenith * brightness),
        sky_horizon=_colour(horizon * brightness),
        cloudiness=float(rng.uniform(0.0, 0.35)),
        ground_light=_colour(ground * (1.0 + contrast / 2)),
        ground_dark=_colour(ground * (1.0 - contrast / 2)),
        ground_texture=int(rng.integers(GROUND_TEXTURES)),
        ground_scale_m=float(rng.uniform(6.0, 24.0)),
        ground_turn_rad=float(rng.uniform(0.0, 2.0 * np.pi)),
        haze_m=float(rng.uniform(30.0, 150.0)),
    )
    pictures = [_one_of(rng, each) for each in (scenery.gate_pictures, scenery.ground_pictures)]
    return replace(look, gate_picture=pictures[0], ground_picture=pictures[1])


def in_fog(look: Look, visibility_m: float) -> Look:
    """Let fog come up, which takes 98 % of the contrast on that way (Koschmieder's visibility)."""
    if math.isinf(visibility_m):
        return look
    fog_m = visibility_m / -math.log(MIN_CONTRAST)
    haze_m = 1.0 / (1.0 / look.haze_m + 1.0 / fog_m)
    return replace(look, fog_m=fog_m, haze_m=haze_m, sky_zenith=look.sky_horizon, cloudiness=0.0)


def at_dusk(look: Look, share: float) -> Look:
    """Leave a share of the daylight, on everything."""
    return replace(
        look,
        cloudiness=look.cloudiness * share,
        ambient=look.ambient * share,
        diffuse=look.diffuse * share,
        sky_zenith=_scaled(look.sky_zenith, share),
        sky_horizon=_scaled(look.sky_horizon, share),
        ground_light=_scaled(look.ground_light, share),
        ground_dark=_scaled(look.ground_dark, share),
    )


def make_texture(index: int) -> NDArray[np.float32]:
    """Make tileable fractal noise with shape (TEXTURE_SIZE, TEXTURE_SIZE), values in 0..1.

    White noise, filtered in the frequency domain to fall as 1 / f^1.3: the look of soil and grass.
    """
    rng = np.random.default_rng([0x7E97, index])
    spectrum = np.fft.rfft2(rng.standard_normal((TEXTURE_SIZE, TEXTURE_SIZE)))
    vertical = np.fft.fftfreq(TEXTURE_SIZE)[:, None]
    horizontal = np.fft.rfftfreq(TEXTURE_SIZE)[None, :]
    frequency = np.hypot(vertical, horizontal)
    frequency[0, 0] = np.inf
    noise = np.fft.irfft2(spectrum / frequency**1.3, s=(TEXTURE_SIZE, TEXTURE_SIZE))
    low, high = np.quantile(noise, [0.01, 0.99])
    return np.asarray(np.clip((noise - low) / (high - low), 0.0, 1.0), dtype=np.float32)


def _one_of(rng: np.random.Generator, paths: tuple[str, ...]) -> str:
    """Draw a path; from none nothing is drawn."""
    return paths[int(rng.integers(len(paths)))] if paths else ""


def _colour(values: NDArray[np.float64]) -> Colour:
    red, green, blue = np.clip(values, 0.0, 1.0)
    return (float(red), float(green), float(blue))


def _scaled(colour: Colour, share: float) -> Colour:
    return (colour[0] * share, colour[1] * share, colour[2] * share)
