"""A map of gates, filtered: time passes, an image is seen, tracks are born, merge and die.

One Kalman filter per gate, all at once: position in the estimate's frame and a drift that comes and
goes (Gauss-Markov); covariances in Joseph's form. Which detection is whose is decided greedily, the
nearest pair by Mahalanobis distance first, so that two gates side by side stay two.
"""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from jaxtyping import Float64
from numpy.typing import NDArray

from flightstack.belief.records import GateTracks
from flightstack.belief.settings import MapSettings
from flightstack.records import GateDetections, Pose

EYE3, EYE6 = np.eye(3), np.eye(6)
Matrices = Float64[NDArray[np.float64], "K 3 3"]
Points = Float64[NDArray[np.float64], "K 3"]
PerGate = Float64[NDArray[np.float64], " K"]


class Sighting(NamedTuple):
    """Detections in the estimate's frame."""

    position_ned: Points
    covariance: Matrices
    heading_rad: PerGate
    heading_var: PerGate
    score: PerGate
    range_m: PerGate


def rotation_of(pose: Pose) -> Float64[NDArray[np.float64], "3 3"]:
    """Return the matrix that turns FRD into NED."""
    cr, sr = math.cos(pose.roll_rad), math.sin(pose.roll_rad)
    cp, sp = math.cos(pose.pitch_rad), math.sin(pose.pitch_rad)
    cy, sy = math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)
    return np.array(
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    )


def sighting_of(detections: GateDetections, pose: Pose, settings: MapSettings) -> Sighting:
    """Turn what one image shows into the frame of the pose of its own stamp."""
    rotation = rotation_of(pose)
    range_m = np.linalg.norm(detections.position_frd, axis=1)
    offset = detections.position_frd @ rotation.T
    covariance = settings.covariance_factor * (rotation @ detections.covariance_frd @ rotation.T)
    along = offset / np.maximum(range_m, 1e-6)[:, None]
    outer = along[:, :, None] * along[:, None, :]
    lateral = settings.lateral_floor_m[0] + settings.lateral_floor_m[1] * range_m
    depth = settings.range_floor_m[0] + settings.range_floor_m[1] * range_m
    covariance = covariance + (lateral**2)[:, None, None] * (EYE3 - outer)
    covariance = covariance + (depth**2)[:, None, None] * outer
    return Sighting(
        position_ned=offset + np.array(pose.position_ned),
        covariance=covariance,
        heading_rad=pose.yaw_rad + detections.heading_rad,
        heading_var=settings.heading_variance_factor * detections.heading_std_rad**2,
        score=detections.score,
        range_m=range_m,
    )


def predict(tracks: GateTracks, elapsed_s: float, settings: MapSettings) -> GateTracks:
    """Let time pass."""
    if not len(tracks) or elapsed_s <= 0.0:
        return tracks
    keep = math.exp(-elapsed_s / settings.drift_time_constant_s)
    transition = EYE6.copy()
    transition[:3, 3:] = elapsed_s * EYE3
    transition[3:, 3:] = keep * EYE3
    noise = np.zeros((6, 6))
    noise[:3, :3] = settings.walk_m_sqrt_s**2 * elapsed_s * EYE3
    noise[3:, 3:] = settings.drift_std_m_s**2 * (1.0 - keep * keep) * EYE3
    covariance = transition @ tracks.covariance @ transition.T + noise
    heading_var = tracks.heading_var + settings.heading_walk_rad_sqrt_s**2 * elapsed_s
    return replace(
        tracks,
        mean=tracks.mean @ transition.T,
        covariance=_capped(covariance, settings.max_position_std_m),
        heading_var=heading_var,
    )


def observe(
    tracks: GateTracks, seen: Sighting, pose: Pose, settings: MapSettings, numbers: int
) -> tuple[GateTracks, int]:
    """Take one image in; returns the tracks, and how many numbers have been given out."""
    pairs = associate(tracks, seen, settings)
    updated = _update(tracks, seen, pairs, settings)
    updated = _missed(updated, {row for row, _ in pairs}, pose, settings)
    taken = {column for _, column in pairs}
    free = [
        column
        for column in range(len(seen.score))
        if column not in taken
        and seen.score[column] >= settings.birth_score
        and seen.range_m[column] >= settings.blind_m
    ]
    born = _born(seen, np.array(free, dtype=np.intp), settings, numbers)
    joined = _merged(_joined(updated, born), settings)
    alive = joined.log_odds >= settings.min_log_odds
    kept = joined.take(alive)
    if len(kept) > settings.max_tracks:
        surest = np.sort(np.argsort(-kept.log_odds, kind="stable")[: settings.max_tracks])
        kept = kept.take(surest)
    return kept, numbers + len(free)


def associate(tracks: GateTracks, seen: Sighting, settings: MapSettings) -> list[tuple[int, int]]:
    """Pair tracks with detections: (row, column), the nearest first, each at most once."""
    if not len(tracks) or not len(seen.score):
        return []
    difference = tracks.position_ned[:, None] - seen.position_ned[None]
    spread = tracks.covariance[:, None, :3, :3] + seen.covariance[None]
    solved = np.linalg.solve(spread, difference[..., None])[..., 0]
    squares = np.einsum("tki,tki->tk", difference, solved)
    pairs: list[tuple[int, int]] = []
    while True:
        row, column = np.unravel_index(np.argmin(squares), squares.shape)
        if not squares[row, column] < settings.gate_chi2:
            return pairs
        pairs.append((int(row), int(column)))
        squares[row, :] = np.inf
        squares[:, column] = np.inf


def _update(
    tracks: GateTracks, seen: Sighting, pairs: list[tuple[int, int]], settings: MapSettings
) -> GateTracks:
    pairs = [(row, column) for row, column in pairs if seen.range_m[column] >= settings.blind_m]
    if not pairs:
        return tracks
    rows, columns = (np.array(each, dtype=np.intp) for each in zip(*pairs, strict=True))
    before, noise = tracks.covariance[rows], seen.covariance[columns]
    spread = before[:, :3, :3] + noise
    gain = np.linalg.solve(spread, before[:, :3, :]).transpose(0, 2, 1)  # (P H') S^-1
    innovation = seen.position_ned[columns] - tracks.mean[rows, :3]
    mean, covariance = tracks.mean.copy(), tracks.covariance.copy()
    mean[rows] += np.einsum("kij,kj->ki", gain, innovation)
    left = np.repeat(EYE6[None], len(rows), axis=0)
    left[:, :, :3] -= gain
    covariance[rows] = left @ before @ left.transpose(0, 2, 1) + gain @ noise @ gain.transpose(
        0, 2, 1
    )
    heading, heading_var = tracks.heading_rad.copy(), tracks.heading_var.copy()
    share = heading_var[rows] / (heading_var[rows] + seen.heading_var[columns])
    heading[rows] += share * _half_turn(seen.heading_rad[columns] - heading[rows])
    heading_var[rows] = np.maximum(
        heading_var[rows] * (1.0 - share), settings.min_heading_std_rad**2
    )
    log_odds, hits = tracks.log_odds.copy(), tracks.hits.copy()
    log_odds[rows] += settings.hit_log_odds * seen.score[columns]
    hits[rows] += 1
    return GateTracks(
        number=tracks.number,
        mean=mean,
        covariance=covariance,
        heading_rad=heading,
        heading_var=heading_var,
        log_odds=np.minimum(log_odds, settings.max_log_odds),
        hits=hits,
    )


def _missed(
    tracks: GateTracks, seen_rows: set[int], pose: Pose, settings: MapSettings
) -> GateTracks:
    """Doubt gates that should be in view, and are not."""
    if not len(tracks):
        return tracks
    offset = (tracks.position_ned - np.array(pose.position_ned)) @ rotation_of(pose)
    ahead = np.maximum(offset[:, 0], 1e-6)
    tangent = np.abs(offset[:, 1:]).max(axis=1) / ahead
    nearest, farthest = settings.expected_m
    distance = np.linalg.norm(offset, axis=1)
    expected = (offset[:, 0] > 0.0) & (tangent < settings.expected_tangent)
    expected &= (distance > nearest) & (distance < farthest)
    expected[list(seen_rows)] = False
    return replace(tracks, log_odds=tracks.log_odds - settings.miss_log_odds * expected)


def _born(
    seen: Sighting, columns: NDArray[np.intp], settings: MapSettings, numbers: int
) -> GateTracks:
    count = len(columns)
    mean = np.zeros((count, 6))
    mean[:, :3] = seen.position_ned[columns]
    covariance = np.zeros((count, 6, 6))
    covariance[:, :3, :3] = seen.covariance[columns]
    covariance[:, 3:, 3:] = settings.drift_std_m_s**2 * EYE3
    return GateTracks(
        number=np.arange(numbers, numbers + count, dtype=np.int64),
        mean=mean,
        covariance=covariance,
        heading_rad=seen.heading_rad[columns],
        heading_var=np.maximum(seen.heading_var[columns], settings.min_heading_std_rad**2),
        log_odds=np.full(count, settings.birth_log_odds),
        hits=np.ones(count, np.int64),
    )


def _merged(tracks: GateTracks, settings: MapSettings) -> GateTracks:
    """Keep of tracks that stand in each other the one that was seen more often."""
    if len(tracks) < 2:
        return tracks
    offset = tracks.position_ned[:, None] - tracks.position_ned[None]
    near = np.linalg.norm(offset, axis=2) < settings.merge_m
    order = np.argsort(-tracks.hits, kind="stable")
    gone = np.zeros(len(tracks), dtype=bool)
    for index, row in enumerate(order):
        if not gone[row]:
            gone[[other for other in order[index + 1 :] if near[row, other]]] = True
    return tracks.take(~gone)


def _joined(one: GateTracks, other: GateTracks) -> GateTracks:
    return GateTracks(
        number=np.concatenate((one.number, other.number)),
        mean=np.concatenate((one.mean, other.mean)),
        covariance=np.concatenate((one.covariance, other.covariance)),
        heading_rad=np.concatenate((one.heading_rad, other.heading_rad)),
        heading_var=np.concatenate((one.heading_var, other.heading_var)),
        log_odds=np.concatenate((one.log_odds, other.log_odds)),
        hits=np.concatenate((one.hits, other.hits)),
    )


def _capped(
    covariance: Float64[NDArray[np.float64], "T 6 6"], max_std_m: float
) -> Float64[NDArray[np.float64], "T 6 6"]:
    """Scale down what has grown beyond what position aiding allows."""
    variance = np.diagonal(covariance[:, :3, :3], axis1=1, axis2=2).max(axis=1)
    factor = np.minimum(1.0, max_std_m**2 / np.maximum(variance, 1e-12))
    return np.asarray(covariance * factor[:, None, None])


def _half_turn(angle: PerGate) -> PerGate:
    """Wrap into [-pi/2, pi/2)."""
    return np.asarray(np.mod(angle + np.pi / 2.0, np.pi) - np.pi / 2.0)
