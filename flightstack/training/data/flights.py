"""Control data: what the camera sees while the expert flies, and what the expert commands.

Recovery states come from execution noise: the vehicle flies the expert's command plus a slow
random disturbance, while the label stays the clean command for where it has been carried.
"""

import math
from collections.abc import Callable

import numpy as np

from flightstack.arrays import Labels, PerVelocity, RgbStack, SmallRgb
from flightstack.errors import UsageError
from flightstack.frames import ned_from_body
from flightstack.records import VELOCITIES
from flightstack.training.data.funnel import Expert, FunnelExpert
from flightstack.training.data.minimum_jerk import MinimumJerkExpert
from flightstack.training.recipe import FlightRecipe
from flightstack.training.seeds import TRAINING_TRACKS
from sitl import (
    CAMERA_RATE_HZ,
    GATE_HEIGHT_M,
    GATES_PER_LAP,
    Conditions,
    CourseState,
    Gate,
    Light,
    OffboardSetpoint,
    Simulation,
    SimulationConfig,
    Vector3,
    yaw_of,
)

MEASURED_EVERY = 10  # images: half a second apart, so that few images tell of many tracks
START_SPEED_M_S = (0.0, 2.0)  # of a flight that starts before a gate
Pilot = Callable[[SmallRgb], PerVelocity]


def fly(
    rng: np.random.Generator,
    recipe: FlightRecipe,
    *,
    tracks: range = TRAINING_TRACKS,
    pilot: Pilot | None = None,
    every: int = 1,
) -> tuple[RgbStack, Labels]:
    """Fly once; images and the expert's commands along the way.

    With a `pilot` the vehicle follows it instead, and the expert only labels (DAgger). Without one,
    only every `every`-th image is rendered and kept; a pilot sees them all.
    """
    at_spawn = bool(rng.random() < recipe.start_at_spawn_share)
    simulation = Simulation(
        SimulationConfig(
            seed=int(rng.integers(2**31)),
            track_seed=int(rng.integers(tracks.start, tracks.stop)),
            noise_m=(
                draw_radius_noise_m(rng, recipe),
                float(rng.uniform(0.0, recipe.most_height_noise_m)),
            ),
            laps=2,
            first_gate=0 if at_spawn else int(rng.integers(GATES_PER_LAP)),
            conditions=Conditions(
                light=Light(fog_visibility_m=recipe.fog.draw_visibility_m(rng)),
                scenery=recipe.scenery,
            ),
        )
    )
    try:
        _take_off(simulation, rng, recipe, at_spawn=at_spawn)
        return _record(simulation, rng, recipe, pilot, 1 if pilot else every)
    finally:
        simulation.close()


def fly_until(
    rng: np.random.Generator, recipe: FlightRecipe, *, tracks: range, images: int
) -> tuple[RgbStack, Labels]:
    """Fly what models are measured on: images and the expert's commands.

    Raises UsageError for fewer than one image.
    """
    if images < 1:
        raise UsageError(f"--images must be 1 or more, got {images}")
    flown, commands, count = [], [], 0
    while count < images:
        one, labels = fly(rng, recipe, tracks=tracks, every=MEASURED_EVERY)
        flown.append(one)
        commands.append(labels)
        count += len(one)
    return np.concatenate(flown)[:images], np.concatenate(commands)[:images]


def draw_radius_noise_m(rng: np.random.Generator, recipe: FlightRecipe) -> float:
    """Draw a track's radius noise, uniformly over what is not held out."""
    low, high = recipe.held_out_radius_noise_m
    drawn = float(rng.uniform(0.0, recipe.most_radius_noise_m - (high - low)))
    return drawn if drawn < low else drawn + (high - low)


def _record(
    simulation: Simulation,
    rng: np.random.Generator,
    recipe: FlightRecipe,
    pilot: Pilot | None,
    every: int,
) -> tuple[RgbStack, Labels]:
    gates = simulation.course_gates
    expert = _make_expert(recipe.expert)
    noise = _Disturbance(rng, recipe)
    images: list[SmallRgb] = []
    labels: list[PerVelocity] = []
    simulation.image_due()
    while len(labels) < recipe.frames and simulation.course.state is CourseState.ACTIVE:
        if len(labels) % every == 0:
            images.append(simulation.render().rgb)
        due = simulation.course.gates_passed
        gate, following = gates[due % len(gates)], gates[(due + 1) % len(gates)]
        label = expert.command(simulation.state, gate, following)
        labels.append(label)
        _command(simulation, label + noise.draw() if pilot is None else pilot(images[-1]))
        while True:
            simulation.step()
            if simulation.image_due():
                break
    if simulation.course.state is CourseState.FAILED:
        labels = labels[: -recipe.lost_frames]
    seen = np.array(labels[::every], dtype=np.float32).reshape(-1, len(VELOCITIES))
    shape = (len(seen), 64, 64, 3)
    return np.array(images[: len(seen)], dtype=np.uint8).reshape(shape), seen


def _take_off(
    simulation: Simulation, rng: np.random.Generator, recipe: FlightRecipe, *, at_spawn: bool
) -> None:
    """Start in the air: above the spawn point, or before the gate that is due."""
    if at_spawn:
        spread = rng.normal(0.0, 0.2, 3)
        position = (float(spread[0]), float(spread[1]), float(spread[2]) - GATE_HEIGHT_M)
        simulation.start_airborne(position, float(rng.normal(0.0, 0.1)))
        return
    position, bearing = _before(simulation.course_gates[0], rng, recipe)
    yaw = bearing + float(rng.normal(0.0, recipe.start_yaw_std_rad))
    simulation.start_airborne(position, yaw, float(rng.uniform(*START_SPEED_M_S)))


def _before(gate: Gate, rng: np.random.Generator, recipe: FlightRecipe) -> tuple[Vector3, float]:
    """Draw a place before a gate, more scattered the farther away; and its bearing to the gate."""
    ahead = float(rng.uniform(*recipe.start_ahead_m))
    right, down = rng.normal(0.0, recipe.start_spread_m * ahead / recipe.start_ahead_m[1], 2)
    # the course comes from the outside of the axis' tangent: half a gate's turn
    bend = math.radians(22.5) * ahead / recipe.start_ahead_m[1]
    axis_n, axis_e = math.cos(gate.yaw_rad - bend), math.sin(gate.yaw_rad - bend)
    centre = gate.centre_ned
    position = (
        centre[0] - ahead * axis_n - float(right) * axis_e,
        centre[1] - ahead * axis_e + float(right) * axis_n,
        min(centre[2] + float(down), -0.5),
    )
    return position, math.atan2(centre[1] - position[1], centre[0] - position[0])


class _Disturbance:
    """An Ornstein-Uhlenbeck process over the four velocities, one step per image."""

    def __init__(self, rng: np.random.Generator, recipe: FlightRecipe) -> None:
        self._rng = rng
        calm = rng.random() < recipe.calm_share
        self._std = np.zeros(4) if calm else np.array(recipe.noise_std)
        self._decay = math.exp(-1.0 / (CAMERA_RATE_HZ * recipe.noise_time_constant_s))
        self._value = self._std * rng.standard_normal(4)

    def draw(self) -> PerVelocity:
        """Advance by one image."""
        kick = self._std * math.sqrt(1.0 - self._decay**2)
        self._value = self._decay * self._value + kick * self._rng.standard_normal(4)
        return self._value


def _make_expert(name: str) -> Expert:
    return MinimumJerkExpert() if name == "minimum-jerk" else FunnelExpert()


def _command(simulation: Simulation, command: PerVelocity) -> None:
    yaw_rad = yaw_of(simulation.state.q_ned_frd)
    vx, vy, vz, yaw_rate = (float(value) for value in command)
    simulation.autopilot.offboard_setpoint(
        OffboardSetpoint(
            time_us=simulation.time_us,
            velocity_ned=ned_from_body((vx, vy, vz), yaw_rad),
            yaw_rate_rad_s=yaw_rate,
        )
    )
