"""Cells into a set of gates, each with a calibrated Gaussian; numpy, pure functions."""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float32
from numpy.typing import NDArray

from flightstack.records import GateDetections

Cells = Float32[NDArray[np.float32], "10 16 16"]
SCORE, U, V, RANGE, COS, SIN, LOGVARS = 0, 1, 2, 3, 4, 5, slice(6, 10)
CELLS, OUTPUTS = 16, 10  # along each side; what each tells
TANGENT = 2.0 / CELLS  # of a cell: the camera sees +-45 deg
MIN_RANGE_M, MAX_RANGE_M = 0.2, 30.0
SAME_CELLS, SAME_LOG_RANGE = 1.6, 0.4  # nearer than both: one gate, told by several cells
MAX_HEADING_STD_RAD = 0.9  # of an angle modulo pi that nobody knows


@dataclass(frozen=True, slots=True, kw_only=True)
class DetectionCalibration:
    """What makes the network's variances those of its errors; from validation scenes."""

    min_score: float = 0.3
    centre_factor: float = 1.0  # on the variance of u and v
    range_factor: float = 1.0  # of the logarithm of the distance
    angle_factor: float = 1.0


def decode(cells: Cells, calibration: DetectionCalibration) -> GateDetections:
    """Return the gates that the cells of one image tell, the surest first."""
    score = 1.0 / (1.0 + np.exp(-cells[SCORE].astype(np.float64)))
    rows, columns = np.nonzero(score >= calibration.min_score)
    order = np.argsort(-score[rows, columns], kind="stable")
    rows, columns = rows[order], columns[order]
    told = cells[:, rows, columns].astype(np.float64)
    u, v = columns + 0.5 + told[U], rows + 0.5 + told[V]
    log_range = np.clip(told[RANGE], np.log(MIN_RANGE_M), np.log(MAX_RANGE_M))
    kept = _distinct(u, v, log_range)
    variances = np.exp(told[LOGVARS][:, kept]) * _factors(calibration)[:, None]
    return _gates(
        u[kept], v[kept], log_range[kept], told[:, kept], variances, score[rows, columns][kept]
    )


def _factors(calibration: DetectionCalibration) -> NDArray[np.float64]:
    centre = calibration.centre_factor
    return np.array([centre, centre, calibration.range_factor, calibration.angle_factor])


def _distinct(
    u: NDArray[np.float64], v: NDArray[np.float64], log_range: NDArray[np.float64]
) -> list[int]:
    """Return the indices of those that no surer one says already."""
    kept: list[int] = []
    for index in range(len(u)):
        near = (
            abs(u[index] - u[one]) < SAME_CELLS
            and abs(v[index] - v[one]) < SAME_CELLS
            and abs(log_range[index] - log_range[one]) < SAME_LOG_RANGE
            for one in kept
        )
        if not any(near):
            kept.append(index)
    return kept


def _gates(
    u: NDArray[np.float64],
    v: NDArray[np.float64],
    log_range: NDArray[np.float64],
    told: NDArray[np.float64],
    variances: NDArray[np.float64],
    score: NDArray[np.float64],
) -> GateDetections:
    right, down = u * TANGENT - 1.0, v * TANGENT - 1.0
    ray = np.stack([np.ones_like(right), right, down], axis=1)
    length = np.linalg.norm(ray, axis=1, keepdims=True)
    unit = ray / length
    distance = np.exp(log_range)[:, None]
    jacobian = np.empty((len(u), 3, 3))  # of the position by u, v, log distance
    for axis, tangent in ((0, right), (1, down)):
        unit_axis = np.zeros(3)
        unit_axis[axis + 1] = 1.0
        slope = (unit_axis - unit * (tangent / length[:, 0])[:, None]) / length
        jacobian[:, :, axis] = distance * slope * TANGENT
    jacobian[:, :, 2] = distance * unit
    covariance = np.einsum("kij,jk,klj->kil", jacobian, variances[:3], jacobian)
    heading = 0.5 * np.arctan2(told[SIN], told[COS]) + np.arctan2(right, 1.0)
    return GateDetections(
        position_frd=distance * unit,
        covariance_frd=covariance,
        heading_rad=np.mod(heading + np.pi / 2.0, np.pi) - np.pi / 2.0,
        heading_std_rad=np.minimum(np.sqrt(variances[3]) / 2.0, MAX_HEADING_STD_RAD),
        score=score,
    )
