"""Make the detector's variances those of its errors, and say how good it is, by distance.

Each factor is the median of the squared errors in units of the variance told, over that of a chi
square: robust against the few gates that are told wrongly altogether. On validation scenes.
"""

from dataclasses import dataclass, replace

import numpy as np
import torch
from numpy.typing import NDArray

from flightstack.networks.gate_network import GateNetwork
from flightstack.networks.images import network_input
from flightstack.perception.gate_decoding import DetectionCalibration, decode
from flightstack.records import GateDetections
from flightstack.training.detector.store import Scenes

SCORES = (0.3, 0.4, 0.5, 0.6, 0.7, 0.8)
MAX_FALSE = 0.75  # an image; the scenes are worse than a course on a fine day
CHI2_MEDIAN = 0.4549  # of one degree of freedom
CHI2_90 = 2.7055
NEAR_PX, NEAR_LOG_RANGE = 6.0, 0.35  # a detection that is a gate's
BANDS_M = ((0.45, 1.0), (1.0, 2.0), (2.0, 4.0), (4.0, 7.0), (7.0, 12.0))
Column = NDArray[np.float64]
UNSEEN = np.full(4, np.nan)


@dataclass(frozen=True, slots=True, kw_only=True)
class Matches:
    """Gates, and what was said of each: NaN where nothing was."""

    distance_m: Column
    errors: Column  # (gates, 4): u, v (tangents), log distance, heading (rad)
    std: Column  # (gates, 4)
    false: int  # detections that are no gate's
    images: int


def calibrate(network: GateNetwork, scenes: Scenes) -> DetectionCalibration:
    """Return the least score with few false gates, and the factors on the variances."""
    for score in SCORES:
        raw = DetectionCalibration(min_score=score)
        found = match(network, scenes, raw)
        if found.false <= MAX_FALSE * found.images:
            break
    seen = np.isfinite(found.errors[:, 0])
    if not seen.any():  # it has learnt nothing yet
        return raw
    squares = (found.errors[seen] / found.std[seen]) ** 2
    medians = np.median(squares, axis=0) / CHI2_MEDIAN
    return replace(
        raw,
        centre_factor=round(float(medians[:2].mean()), 3),
        range_factor=round(float(medians[2]), 3),
        angle_factor=round(float(medians[3]), 3),
    )


def match(network: GateNetwork, scenes: Scenes, calibration: DetectionCalibration) -> Matches:
    """Compare what is detected with what is there."""
    distances, errors, stds, false = [], [], [], 0
    with torch.inference_mode():
        for start in range(0, len(scenes), 200):
            rows = slice(start, start + 200)
            cells = network(network_input(scenes.images[rows])).numpy()
            for one, labels in zip(cells, scenes.labels[rows], strict=True):
                gates = labels[np.isfinite(labels[:, 0])].astype(np.float64)
                found = decode(one, calibration)
                taken: set[int] = set()
                for gate in gates:
                    index = _nearest(gate, found, taken)
                    distances.append(gate[2])
                    errors.append(
                        np.full(4, np.nan) if index is None else _errors(gate, found, index)
                    )
                    stds.append(np.full(4, np.nan) if index is None else _std(found, index))
                    taken |= set() if index is None else {index}
                false += len(found.score) - len(taken)
    return Matches(
        distance_m=np.array(distances),
        errors=np.array(errors).reshape(-1, 4),
        std=np.array(stds).reshape(-1, 4),
        false=false,
        images=len(scenes),
    )


def metrics_of(found: Matches) -> dict[str, object]:
    """Return recall, errors and coverage of 90 % intervals, by distance."""
    bands = {}
    for low, high in BANDS_M:
        inside = (found.distance_m >= low) & (found.distance_m < high)
        seen = inside & np.isfinite(found.errors[:, 0])
        if not seen.any():
            continue
        errors, std = found.errors[seen], found.std[seen]
        covered = (errors / std) ** 2 <= CHI2_90
        bands[f"{low:g}-{high:g} m"] = {
            "gates": int(inside.sum()),
            "recall": round(float(seen.sum() / inside.sum()), 3),
            "azimuth_deg": _median_deg(errors[:, 0]),
            "elevation_deg": _median_deg(errors[:, 1]),
            "range_share": round(float(np.median(np.abs(errors[:, 2]))), 3),
            "heading_deg": _median_deg(errors[:, 3]),
            "covered_90": [round(float(share), 3) for share in covered.mean(axis=0)],
        }
    return {"false_per_image": round(found.false / found.images, 3), "bands": bands}


def _median_deg(errors: Column) -> float:
    return round(float(np.degrees(np.median(np.abs(errors)))), 2)


def _tangents(found: GateDetections) -> Column:
    return found.position_frd[:, 1:] / found.position_frd[:, :1]


def _nearest(gate: Column, found: GateDetections, taken: set[int]) -> int | None:
    if not len(found.score):
        return None
    tangents = _tangents(found)
    apart_px = np.hypot(*((tangents - (gate[:2] / 32.0 - 1.0)) * 32.0).T)
    ranges = np.log(np.linalg.norm(found.position_frd, axis=1) / gate[2])
    apart_px = np.where(np.abs(ranges) < NEAR_LOG_RANGE, apart_px, np.inf)
    apart_px[list(taken)] = np.inf
    best = int(np.argmin(apart_px))
    return best if apart_px[best] < NEAR_PX else None


def _errors(gate: Column, found: GateDetections, index: int) -> Column:
    tangent = _tangents(found)[index] - (gate[:2] / 32.0 - 1.0)
    log_range = np.log(np.linalg.norm(found.position_frd[index]) / gate[2])
    truth = gate[3] + np.arctan2(gate[0] / 32.0 - 1.0, 1.0)
    heading = np.mod(found.heading_rad[index] - truth + np.pi / 2, np.pi) - np.pi / 2
    return np.array([*tangent, log_range, heading])


def _std(found: GateDetections, index: int) -> Column:
    """Return the standard deviations of tangents, log distance and heading."""
    position, covariance = found.position_frd[index], found.covariance_frd[index]
    distance = float(np.linalg.norm(position))
    along = position / distance
    ahead = position[0]
    slopes = np.array(
        [[-position[1] / ahead**2, 1 / ahead, 0.0], [-position[2] / ahead**2, 0.0, 1 / ahead]]
    )
    lateral = np.sqrt(np.diagonal(slopes @ covariance @ slopes.T))
    depth = np.sqrt(along @ covariance @ along) / distance
    return np.array([*lateral, depth, found.heading_std_rad[index]])
