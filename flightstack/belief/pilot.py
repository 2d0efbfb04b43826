"""A belief turned into commands: M samples of the next gate, when the command acts, by the law.

The command is a velocity that the vehicle holds by an estimate of its own, which drifts: so what
the estimate says of the velocity beyond what its position does is added, and what the gate drifts.
"""

import math
from dataclasses import dataclass, field, replace

import numpy as np
from jaxtyping import Float64
from numpy.typing import NDArray

from flightstack.belief.course import Geometry, bearing, describe, has_passed, weigh
from flightstack.belief.law import velocities
from flightstack.belief.mapping import observe, predict, sighting_of
from flightstack.belief.records import Belief, NextGate, PassedGate
from flightstack.belief.settings import CourseSettings, LawSettings, MapSettings
from flightstack.frames import wrap_pi
from flightstack.records import ActionSamples, GateDetections, Pose

SECOND_US = 1_000_000
MIN_VARIANCE = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class BeliefSettings:
    """All numbers of a pilot on belief."""

    map: MapSettings = field(default_factory=MapSettings)
    course: CourseSettings = field(default_factory=CourseSettings)
    law: LawSettings = field(default_factory=LawSettings)
    samples: int = 32
    pair_side: str | None = None  # "left" or "right": which of two gates side by side is meant


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleMotion:
    """What telemetry tells of the vehicle now."""

    pose: Pose  # the newest
    displacement_m_s: tuple[float, float, float]  # of the position told, over the last moments


def see(belief: Belief, detections: GateDetections, pose: Pose, settings: BeliefSettings) -> Belief:
    """Take in what one image shows, from the pose of its own stamp."""
    elapsed_s = 0.0 if belief.time_us < 0 else (pose.time_us - belief.time_us) / SECOND_US
    tracks = predict(belief.tracks, min(max(elapsed_s, 0.0), 1.0), settings.map)
    seen = sighting_of(detections, pose, settings.map)
    tracks, numbers = observe(tracks, seen, pose, settings.map, belief.numbers)
    return replace(
        belief, time_us=max(belief.time_us, pose.time_us), tracks=tracks, numbers=numbers
    )


def choose(belief: Belief, pose: Pose, settings: BeliefSettings) -> tuple[Belief, NextGate | None]:
    """Decide which gate is next; one that has been passed is noted, and the one after it is."""
    for _ in range(2):
        found = _likeliest(belief, pose, settings)
        if found is None:
            return replace(belief, target=None), None
        if not has_passed(found, pose, settings.course):
            return _aiming(belief, found, pose), found
        north, east, down = found.position_ned.tolist()
        passed = PassedGate(
            number=found.number, position_ned=(north, east, down), axis_rad=found.axis_rad
        )
        belief = replace(belief, passed=(*belief.passed, passed), target=None)
    return belief, None


def act(
    belief: Belief,
    gate: NextGate | None,
    motion: VehicleMotion,
    settings: BeliefSettings,
    rng: np.random.Generator,
) -> ActionSamples:
    """Return the commands (1, M, 4) that samples of the belief ask for, body frame."""
    pose, law = motion.pose, settings.law
    displacement = np.array(motion.displacement_m_s)
    ahead_ned = np.array(pose.position_ned) + displacement * law.lead_s
    count = settings.samples
    if gate is None:
        wanted, yaw_rate = _search(belief, pose, settings)
        velocity_ned = np.repeat(wanted[None], count, axis=0)
        yaw_rates = np.full(count, yaw_rate)
    else:
        centre = gate.position_ned + gate.drift_ned * law.lead_s
        spread = _root(gate.covariance) @ rng.standard_normal((3, count))
        axis = gate.axis_rad + gate.axis_std_rad * rng.standard_normal(count)
        centres = centre + spread.T
        velocity_ned, yaw_rates = velocities(
            centres,
            axis,
            np.repeat(gate.following_ned[None], count, axis=0),
            np.repeat(ahead_ned[None], count, axis=0),
            pose.yaw_rad,
            law,
        )
        velocity_ned = velocity_ned + gate.drift_ned
    slip = np.array(pose.velocity_ned) - displacement
    return _in_body(velocity_ned + slip, yaw_rates, pose.yaw_rad, law)


def _likeliest(belief: Belief, pose: Pose, settings: BeliefSettings) -> NextGate | None:
    if not len(belief.tracks):
        return None
    weights = weigh(belief, pose, settings.course, settings.pair_side)
    best = int(np.argmax(weights))
    if not np.isfinite(weights[best]):
        return None
    share = np.exp(weights - weights[best])
    return describe(belief, best, float(1.0 / share.sum()), pose, settings.course)


def _aiming(belief: Belief, gate: NextGate, pose: Pose) -> Belief:
    if belief.target == gate.number:
        return belief
    approach_rad = bearing(gate.position_ned, pose)
    return replace(belief, target=gate.number, approach_rad=approach_rad)


def _search(
    belief: Belief, pose: Pose, settings: BeliefSettings
) -> tuple[NDArray[np.float64], float]:
    """Go to where the next gate is expected, looking there; turn where nothing tells."""
    law = settings.law
    expected = Geometry(belief.passed, settings.course).expected_ned()
    if expected is None:
        return np.zeros(3), law.search_yaw_rate_rad_s
    offset = expected - np.array(pose.position_ned)
    distance = float(np.linalg.norm(offset))
    error = wrap_pi(bearing(expected, pose) - pose.yaw_rad)
    near = distance < settings.course.lock_m
    if near:
        return np.zeros(3), math.copysign(law.search_yaw_rate_rad_s, error)
    speed = law.search_speed_m_s * max(0.0, math.cos(error))
    limit = law.max_yaw_rate_rad_s
    return offset / distance * speed, max(-limit, min(limit, law.yaw_gain_1_s * error))


def _in_body(
    velocity_ned: Float64[NDArray[np.float64], "M 3"],
    yaw_rates: Float64[NDArray[np.float64], " M"],
    yaw_rad: float,
    law: LawSettings,
) -> ActionSamples:
    cos_yaw, sin_yaw = math.cos(yaw_rad), math.sin(yaw_rad)
    north, east, down = velocity_ned.T
    mean = np.stack(
        [cos_yaw * north + sin_yaw * east, cos_yaw * east - sin_yaw * north, down, yaw_rates],
        axis=1,
    )[None]
    variance = np.broadcast_to(np.square(law.command_std), mean.shape)
    return ActionSamples(mean=mean, var=np.array(variance))


def _root(covariance: Float64[NDArray[np.float64], "3 3"]) -> Float64[NDArray[np.float64], "3 3"]:
    """Return a square root of a covariance, though rounding may have cost it its definiteness."""
    values, vectors = np.linalg.eigh(covariance)
    return np.asarray(vectors * np.sqrt(np.maximum(values, MIN_VARIANCE)))
