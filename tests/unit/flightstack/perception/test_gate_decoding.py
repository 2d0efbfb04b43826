"""Cells become gates: where they are, how sure, and each once."""

import math
from pathlib import Path

import numpy as np
import pytest
import torch

from flightstack.networks.export import export_detector
from flightstack.networks.gate_network import GateNetwork
from flightstack.perception.gate_decoding import (
    CELLS,
    OUTPUTS,
    Cells,
    DetectionCalibration,
    decode,
)
from flightstack.perception.gate_detector import GateDetector
from tests.unit.flightstack.exported import pixels

CALIBRATION = DetectionCalibration()
SURE, VARIANCE = 4.0, 0.01


def no_cells() -> Cells:
    cells = np.zeros((OUTPUTS, CELLS, CELLS), np.float32)
    cells[0] = -8.0
    return cells


def tell(
    cells: Cells, row: int, column: int, *, distance_m: float = 4.0, angle_rad: float = 0.0
) -> None:
    """Let a cell tell a gate in its middle."""
    told = [SURE, 0.0, 0.0, math.log(distance_m), math.cos(2 * angle_rad), math.sin(2 * angle_rad)]
    cells[:6, row, column] = told
    cells[6:, row, column] = math.log(VARIANCE)


def test_nothing_told_is_no_gate() -> None:
    found = decode(no_cells(), CALIBRATION)
    assert found.position_frd.shape == (0, 3)
    assert found.covariance_frd.shape == (0, 3, 3)


@pytest.mark.parametrize(("row", "column"), [(7, 8), (0, 0), (12, 3)])
def test_a_gate_is_along_the_ray_of_its_cell_at_its_distance(row: int, column: int) -> None:
    cells = no_cells()
    tell(cells, row, column, distance_m=5.0)
    found = decode(cells, CALIBRATION)
    ahead, right, down = found.position_frd[0]
    assert math.sqrt(ahead**2 + right**2 + down**2) == pytest.approx(5.0)
    assert right / ahead == pytest.approx((column + 0.5) / 8.0 - 1.0)
    assert down / ahead == pytest.approx((row + 0.5) / 8.0 - 1.0)
    assert found.score[0] == pytest.approx(1.0 / (1.0 + math.exp(-SURE)))


def test_the_covariance_is_that_of_samples_of_what_the_cell_tells() -> None:
    rng = np.random.default_rng(0)
    cells = no_cells()
    tell(cells, 5, 11, distance_m=3.0)
    found = decode(cells, CALIBRATION)
    std = 0.02
    u, v, r = rng.normal(0.0, std, (3, 20_000))
    right, down = (11.5 + u) / 8.0 - 1.0, (5.5 + v) / 8.0 - 1.0
    ray = np.stack([np.ones_like(right), right, down], axis=1)
    points = 3.0 * np.exp(r)[:, None] * ray / np.linalg.norm(ray, axis=1, keepdims=True)
    assert found.covariance_frd[0] * std**2 / VARIANCE == pytest.approx(
        np.cov(points.T), rel=0.1, abs=2e-5
    )


@pytest.mark.parametrize("angle_rad", [-1.2, 0.0, 0.7])
def test_a_heading_is_the_angle_seen_beside_the_line_of_sight(angle_rad: float) -> None:
    cells = no_cells()
    tell(cells, 8, 12, angle_rad=angle_rad)
    found = decode(cells, CALIBRATION)
    sight = math.atan2(12.5 / 8.0 - 1.0, 1.0)
    assert math.remainder(found.heading_rad[0] - angle_rad - sight, math.pi) == pytest.approx(
        0.0, abs=1e-6
    )
    assert -math.pi / 2 <= found.heading_rad[0] < math.pi / 2
    assert found.heading_std_rad[0] == pytest.approx(math.sqrt(VARIANCE) / 2)


def test_what_neighbours_say_of_one_gate_is_one_gate_and_twins_are_two() -> None:
    cells = no_cells()
    tell(cells, 7, 7, distance_m=4.0)
    tell(cells, 7, 8, distance_m=4.3)  # its neighbour
    tell(cells, 7, 12, distance_m=4.0)  # 2.4 m beside it, at that distance
    assert len(decode(cells, CALIBRATION).score) == 2


def test_calibration_widens_what_is_told() -> None:
    cells = no_cells()
    tell(cells, 7, 7)
    wide = decode(cells, DetectionCalibration(centre_factor=4.0, range_factor=4.0))
    narrow = decode(cells, CALIBRATION)
    assert wide.covariance_frd == pytest.approx(4.0 * narrow.covariance_frd)


def test_a_detector_gives_what_its_cells_tell_whatever_the_weights(tmp_path: Path) -> None:
    torch.manual_seed(0)
    form = export_detector(tmp_path, GateNetwork(), pixels())
    detector = GateDetector(
        tmp_path, DetectionCalibration(min_score=0.01), sha256=form.detector_sha256
    )
    image = pixels(seed=3)[0]
    one, other = detector.detect(image), detector.detect(image)
    assert len(one.score) > 0
    assert np.array_equal(one.position_frd, other.position_frd)
    for covariance in one.covariance_frd:
        assert np.linalg.eigvalsh(covariance).min() >= -1e-12
