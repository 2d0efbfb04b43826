"""The course: eight gates on a circle, displaced by seeded noise.

Everything is in local NED, whose origin is the spawn point: on the ground, 4.7 m before the
nominal first gate, with the vehicle's nose (north) pointing at it.

References: Arnez et al. 2022 (radius and height noise), Bonatti et al. 2020 (geometry, start).
"""

import math
from dataclasses import dataclass, replace

import numpy as np

from sitl.errors import UsageError
from sitl.frames import wrap_pi
from sitl.records.course import Direction, Gate

GATES_PER_LAP = 8
RADIUS_M = 8.0
GATE_HEIGHT_M = 3.0  # centre of a gate without noise, above the ground
START_DISTANCE_M = 4.7  # spawn point to nominal gate 0
MAX_RADIUS_NOISE_M = 4.0  # beyond it neighbouring gates may touch
MAX_HEIGHT_NOISE_M = 8.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Track:
    """Gates in flying order, their direction as seen from above, and the circle's centre."""

    gates: tuple[Gate, ...]
    direction: Direction
    centre_ned: tuple[float, float, float]  # m
    decoys: tuple[Gate, ...] = ()  # gates beside them that do not count


def make_track(
    seed: int,
    *,
    radius_noise_m: float = 0.0,
    height_noise_m: float = 0.0,
    direction: Direction = "cw",
) -> Track:
    """Lay out one course.

    Each gate's radius gets U[-radius_noise, radius_noise) and its height U[0, height_noise), so
    noise only ever raises a gate; its axis stays tangent to the circle. The anticlockwise course
    of a seed is the mirror image of its clockwise one.

    Raises:
        UsageError: a noise is negative, not finite, or larger than the course allows.

    """
    _check_noise("radius noise (GRN)", radius_noise_m, MAX_RADIUS_NOISE_M)
    _check_noise("height noise (GHN)", height_noise_m, MAX_HEIGHT_NOISE_M)
    rng = np.random.default_rng(seed)
    radius_offsets = rng.uniform(-radius_noise_m, radius_noise_m, GATES_PER_LAP)
    height_offsets = rng.uniform(0.0, height_noise_m, GATES_PER_LAP)

    # The start chord subtends this angle; the nose points along the chord, which is north.
    chord_angle = 2.0 * math.asin(START_DISTANCE_M / (2.0 * RADIUS_M))
    spawn_azimuth = -math.pi / 2.0 - chord_angle / 2.0  # of the spawn point, seen from the centre
    side = 1.0 if direction == "cw" else -1.0
    centre_north = -RADIUS_M * math.cos(spawn_azimuth)
    centre_east = -RADIUS_M * math.sin(spawn_azimuth)

    gates = []
    for index in range(GATES_PER_LAP):
        azimuth = spawn_azimuth + chord_angle + index * 2.0 * math.pi / GATES_PER_LAP
        radius = RADIUS_M + float(radius_offsets[index])
        north = centre_north + radius * math.cos(azimuth)
        east = side * (centre_east + radius * math.sin(azimuth))
        height = GATE_HEIGHT_M + float(height_offsets[index])
        yaw = wrap_pi(side * (azimuth + math.pi / 2.0))
        gates.append(Gate(index=index, centre_ned=(north, east, -height), yaw_rad=yaw))
    return Track(
        gates=tuple(gates),
        direction=direction,
        centre_ned=(centre_north, side * centre_east, -GATE_HEIGHT_M),
    )


def with_decoys(track: Track, inwards_m: float) -> Track:
    """Put a second gate beside each one: towards the middle of the course, or away from it.

    Both face the same way and stand equally high. Inwards is right on the clockwise course.
    """
    side = inwards_m if track.direction == "cw" else -inwards_m  # m to the right
    decoys = []
    for gate in track.gates:
        north, east, down = gate.centre_ned
        north -= side * math.sin(gate.yaw_rad)
        east += side * math.cos(gate.yaw_rad)
        decoys.append(replace(gate, centre_ned=(north, east, down)))
    return replace(track, decoys=tuple(decoys))


def _check_noise(name: str, value: float, largest: float) -> None:
    if not 0.0 <= value <= largest:  # also refuses NaN
        raise UsageError(f"{name} is {value:g} m: give a number from 0 to {largest:g}")
