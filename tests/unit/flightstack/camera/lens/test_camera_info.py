"""Calibrations are read as ROS and OpenCV write them; what is none is one clear line."""

from pathlib import Path

import cv2
import numpy as np
import pytest

from flightstack.camera.lens.camera_info import read_camera_info, write_camera_info
from flightstack.errors import UsageError
from tests.lenses import FISHEYE, RATIONAL, STRONG

ROS = """image_width: 640
image_height: 480
camera_name: narrow_stereo
camera_matrix:
  rows: 3
  cols: 3
  data: [433.4, 0, 320.5,
         0., 434, 240, 0, 0, 1]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [-.3, 0.1, 0.0, 1e-3, 0]
rectification_matrix: {rows: 3, cols: 3, data: [1, 0, 0, 0, 1, 0, 0, 0, 1]}
"""


def test_a_file_of_ros_is_read(tmp_path: Path) -> None:
    path = tmp_path / "camera.yaml"
    path.write_text(ROS)
    info = read_camera_info(path)
    assert (info.width_px, info.height_px, info.model) == (640, 480, "plumb_bob")
    assert info.matrix.tolist() == [[433.4, 0, 320.5], [0, 434, 240], [0, 0, 1]]
    assert info.coefficients.tolist() == [-0.3, 0.1, 0, 1e-3, 0]


def test_a_file_of_opencv_is_read(tmp_path: Path) -> None:
    path = tmp_path / "camera.yml"
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    storage.write("image_width", 640)
    storage.write("image_height", 480)
    storage.write("camera_matrix", RATIONAL.matrix)
    storage.write("distortion_coefficients", RATIONAL.coefficients[None])
    storage.release()
    info = read_camera_info(path)
    assert (info.width_px, info.height_px, info.model) == (640, 480, "rational_polynomial")
    assert np.array_equal(info.matrix, RATIONAL.matrix)
    assert np.array_equal(info.coefficients, RATIONAL.coefficients)


@pytest.mark.parametrize("info", [STRONG, RATIONAL, FISHEYE], ids=lambda info: info.model)
def test_what_is_written_is_read_again(tmp_path: Path, info: object) -> None:
    path = tmp_path / "camera.yaml"
    write_camera_info(path, info, "made by a test")  # type: ignore[arg-type]
    again = read_camera_info(path)
    assert np.array_equal(again.matrix, info.matrix)  # type: ignore[attr-defined]
    assert (again.model, again.width_px) == (info.model, info.width_px)  # type: ignore[attr-defined]


@pytest.mark.parametrize(
    ("was", "becomes", "why"),
    [
        ("image_width: 640", "", "image_width is missing"),
        ("image_width: 640", "image_width: 0", "image_width and image_height are 0 x 480"),
        ("433.4, 0, 320.5", "433.4, 0, 920.5", "no camera of this size"),
        ("433.4, 0", "433.4", "camera_matrix has 8 numbers, not 9"),
        ("[433.4", "[.nan", "camera_matrix is not finite"),
        ("camera_matrix", "matrix", "camera_matrix with its data is missing"),
        ("plumb_bob", "equidistant", "distortion_model equidistant with 5 coefficients"),
        ("plumb_bob", "thin_prism", "distortion_model thin_prism with 5 coefficients"),
        ("data: [433", "data: [[433", "no YAML"),
    ],
)
def test_what_is_no_calibration_is_told(tmp_path: Path, was: str, becomes: str, why: str) -> None:
    path = tmp_path / "camera.yaml"
    assert was in ROS
    path.write_text(ROS.replace(was, becomes, 1))
    with pytest.raises(UsageError, match=why) as refusal:
        read_camera_info(path)
    assert str(refusal.value).startswith(f"--camera-info {path}: ")
    assert "\n" not in str(refusal.value)


def test_a_file_that_cannot_be_read_is_told(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="No such file"):
        read_camera_info(tmp_path / "none.yaml")
    (tmp_path / "picture.yaml").write_bytes(b"\x89PNG\xff")
    with pytest.raises(UsageError, match="no text"):
        read_camera_info(tmp_path / "picture.yaml")
