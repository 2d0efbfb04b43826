"""Which gate is next: the geometry of a course learned from gates passed, weighed against the map.

Geometry is learned from positions, never from headings that were seen: those are poor, and a gate
looks the same from behind. Left and right are told by the course's heading.
"""

import itertools
import math

import numpy as np
from jaxtyping import Bool, Float64
from numpy.typing import NDArray

from flightstack.belief.records import Belief, GateTracks, NextGate, PassedGate
from flightstack.belief.settings import CourseSettings
from flightstack.frames import wrap_pi
from flightstack.records import Pose

Weights = Float64[NDArray[np.float64], " T"]
Flags = Bool[NDArray[np.bool_], " T"]
LEARNED = 3  # gates passed, from which on chords and turns are known
SIDES = {"left": -1.0, "right": 1.0}


class Geometry:
    """What the gates passed so far tell of the one to come."""

    def __init__(self, passed: tuple[PassedGate, ...], settings: CourseSettings) -> None:
        points = np.array([gate.position_ned for gate in passed[-6:]]).reshape(-1, 3)
        chords = np.diff(points[:, :2], axis=0)
        self.is_learned = len(points) >= LEARNED
        known = 1 if self.is_learned else 0
        self.chord_m = settings.chord_m
        self.turn_rad = 0.0
        self.turn_std_rad = settings.turn_std_rad[known]
        self.chord_std_m = settings.chord_std_m[known]
        self.axis_std_rad = settings.axis_std_rad[known]
        directions = [math.atan2(east, north) for north, east in chords.tolist()]
        if len(chords):
            self.chord_m = float(np.mean(np.linalg.norm(chords, axis=1)))
        if self.is_learned:
            turns = [wrap_pi(b - a) for a, b in itertools.pairwise(directions)]
            self.turn_rad = float(np.mean(turns))
        last = passed[-1] if passed else None
        self.last_ned = np.array((0.0, 0.0, 0.0) if last is None else last.position_ned)
        self.has_begun = last is not None
        if self.is_learned:
            self.axis_rad = wrap_pi(directions[-1] + self.turn_rad / 2.0)
        else:
            self.axis_rad = 0.0 if last is None else last.axis_rad

    @property
    def direction_rad(self) -> float:
        """From the last gate to the next."""
        return wrap_pi(self.axis_rad + self.turn_rad / 2.0)

    @property
    def next_axis_rad(self) -> float:
        """In which the next gate is expected to stand."""
        return wrap_pi(self.axis_rad + self.turn_rad)

    def expected_ned(self) -> NDArray[np.float64] | None:
        """Where the next gate is expected; None before the first was passed."""
        if not self.has_begun:
            return None
        return self.last_ned + _step(self.direction_rad, self.chord_m)


def weigh(belief: Belief, pose: Pose, settings: CourseSettings, pair_side: str | None) -> Weights:
    """Return how well each track would be the next gate: log-weights, -inf where it cannot be."""
    tracks = belief.tracks
    geometry = Geometry(belief.passed, settings)
    weights = -np.logaddexp(0.0, -tracks.log_odds)
    weights = np.where(tracks.log_odds >= settings.min_existence, weights, -np.inf)
    recent = [gate.number for gate in belief.passed[-settings.recent :]]
    weights[np.isin(tracks.number, recent)] = -np.inf
    if not geometry.has_begun:
        weights += _first(tracks, pose, settings)
    else:
        weights += _after(tracks, geometry, settings)
        away_m = np.linalg.norm(tracks.position_ned - geometry.last_ned, axis=1)
        weights[away_m < settings.pair_gap_m[0]] = -np.inf  # just passed, under another number
    if pair_side is not None:
        axes = course_at(tracks, geometry, pose)
        wrong = wrong_side(tracks, axes, SIDES[pair_side], settings)
        weights -= settings.wrong_side_penalty * wrong
    if belief.target is not None:
        weights += settings.stay_bonus * (tracks.number == belief.target)
        locked = _is_locked(tracks, belief.target, pose, settings)
        if locked.any():
            return np.where(locked, 0.0, -np.inf)
    return weights


def course_at(tracks: GateTracks, geometry: Geometry, pose: Pose) -> Weights:
    """Return the course's heading at each gate, were it the next one, rad.

    A chord of a circle stands halfway between the headings at its ends.
    """
    if geometry.is_learned or not geometry.has_begun:
        heading = geometry.next_axis_rad if geometry.has_begun else pose.yaw_rad
        return np.full(len(tracks), heading)
    offset = tracks.position_ned - geometry.last_ned
    chord = np.arctan2(offset[:, 1], offset[:, 0])
    return np.asarray(2.0 * chord - geometry.axis_rad)


def wrong_side(
    tracks: GateTracks, course_rad: Weights, side: float, settings: CourseSettings
) -> Flags:
    """Say which gates have a twin on the side that the mission states (-1 left, 1 right)."""
    axis_n, axis_e = np.cos(course_rad)[:, None], np.sin(course_rad)[:, None]
    offset = tracks.position_ned[None] - tracks.position_ned[:, None]
    ahead = offset[..., 0] * axis_n + offset[..., 1] * axis_e
    right = -offset[..., 0] * axis_e + offset[..., 1] * axis_n
    nearest, farthest = settings.pair_gap_m
    twin = (np.abs(ahead) < settings.pair_ahead_m) & (
        np.abs(offset[..., 2]) < settings.pair_height_m
    )
    twin &= (right * side > nearest) & (right * side < farthest)
    twin &= (tracks.log_odds >= settings.min_existence)[None]
    return np.asarray(twin.any(axis=1))


def describe(
    belief: Belief, row: int, probability: float, pose: Pose, settings: CourseSettings
) -> NextGate:
    """Say what is believed of one track as the next gate."""
    tracks = belief.tracks
    geometry = Geometry(belief.passed, settings)
    centre = tracks.mean[row, :3]
    if not geometry.has_begun:
        is_target = belief.target == int(tracks.number[row])
        prior = belief.approach_rad if is_target else bearing(centre, pose)
    else:
        chord = centre - geometry.last_ned
        prior = math.atan2(chord[1], chord[0]) + geometry.turn_rad / 2.0
    axis, std = _fused_axis(
        float(tracks.heading_rad[row]),
        float(tracks.heading_var[row]),
        prior,
        geometry.axis_std_rad,
        settings.max_axis_rad,
    )
    return NextGate(
        number=int(tracks.number[row]),
        position_ned=centre,
        covariance=tracks.covariance[row, :3, :3],
        drift_ned=tracks.mean[row, 3:],
        axis_rad=axis,
        axis_std_rad=std,
        following_ned=centre + _step(axis + geometry.turn_rad / 2.0, geometry.chord_m),
        probability=probability,
    )


def bearing(place: NDArray[np.float64], pose: Pose) -> float:
    """Return the heading from the vehicle to a place, rad."""
    north, east = place[:2] - np.array(pose.position_ned[:2])
    return math.atan2(east, north)


def has_passed(gate: NextGate, pose: Pose, settings: CourseSettings) -> bool:
    """Whether the vehicle is behind the gate's plane, and went through near its centre."""
    offset = np.array(pose.position_ned) - gate.position_ned
    axis_n, axis_e = math.cos(gate.axis_rad), math.sin(gate.axis_rad)
    along = offset[0] * axis_n + offset[1] * axis_e
    beside = math.hypot(-offset[0] * axis_e + offset[1] * axis_n, offset[2])
    return bool(along > settings.passed_behind_m and beside < settings.passed_beside_m)


def _first(tracks: GateTracks, pose: Pose, settings: CourseSettings) -> Weights:
    """Before any was passed: the nearest ahead of the nose."""
    offset = tracks.position_ned - np.array(pose.position_ned)
    distance = np.linalg.norm(offset, axis=1)
    aside = np.arctan2(offset[:, 1], offset[:, 0]) - pose.yaw_rad
    turned = np.mod(aside + np.pi, 2.0 * np.pi) - np.pi
    return np.asarray(
        -0.5 * (distance / settings.first_range_m) ** 2
        - 0.5 * (turned / settings.first_bearing_std_rad) ** 2
    )


def _after(tracks: GateTracks, geometry: Geometry, settings: CourseSettings) -> Weights:
    """After the last one: a chord farther, turned as the course turns."""
    del settings
    offset = tracks.position_ned - geometry.last_ned
    distance = np.linalg.norm(offset[:, :2], axis=1)
    aside = np.arctan2(offset[:, 1], offset[:, 0]) - geometry.direction_rad
    turned = np.mod(aside + np.pi, 2.0 * np.pi) - np.pi
    return np.asarray(
        -0.5 * ((distance - geometry.chord_m) / geometry.chord_std_m) ** 2
        - 0.5 * (turned / geometry.turn_std_rad) ** 2
    )


def _is_locked(tracks: GateTracks, target: int, pose: Pose, settings: CourseSettings) -> Flags:
    near = np.linalg.norm(tracks.position_ned - np.array(pose.position_ned), axis=1)
    return np.asarray((tracks.number == target) & (near < settings.lock_m))


def _fused_axis(
    seen: float, seen_var: float, prior: float, prior_std: float, max_rad: float
) -> tuple[float, float]:
    """Fuse a heading modulo pi with what the course says, which knows the direction of travel."""
    difference = math.remainder(seen - prior, math.pi)
    share = prior_std**2 / (prior_std**2 + seen_var)
    turned = share * max(-max_rad, min(max_rad, difference))
    return wrap_pi(prior + turned), prior_std * math.sqrt(1.0 - share)


def _step(direction_rad: float, length_m: float) -> NDArray[np.float64]:
    return length_m * np.array([math.cos(direction_rad), math.sin(direction_rad), 0.0])
