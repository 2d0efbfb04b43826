"""Read and write the calibration of a camera: the YAML file of ROS or of OpenCV.

Pixel coordinates are OpenCV's: the centre of the first pixel is (0, 0), x to the right, y down.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from jaxtyping import Float64
from numpy.typing import NDArray

from flightstack.errors import UsageError
from flightstack.files import write_whole

# Distortion models by ROS's names, and how many coefficients each may have (sensor_msgs/CameraInfo,
# distortion_models.hpp; OpenCV's calib3d: k1 k2 p1 p2 k3 k4 k5 k6, its fisheye: k1 k2 k3 k4).
MODELS = {"plumb_bob": (4, 5), "rational_polynomial": (8,), "equidistant": (4,)}
BY_COUNT = {4: "plumb_bob", 5: "plumb_bob", 8: "rational_polynomial"}  # a file that names none
HEADER = "%YAML:1.0\n---\n"  # what OpenCV's reader wants first, and ROS does not write
MAX_FILE_BYTES = 1 << 20
LARGEST_PX = 1 << 15


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraInfo:
    """A camera's size, its pinhole, and what its lens does beside that."""

    width_px: int
    height_px: int
    matrix: Float64[NDArray[np.float64], "3 3"]  # fx 0 cx, 0 fy cy, 0 0 1: pixels
    model: str  # one of MODELS
    coefficients: Float64[NDArray[np.float64], " C"]


def read_camera_info(path: Path) -> CameraInfo:
    """Read a calibration; raises UsageError, in one line, where the file holds none."""
    try:
        if path.stat().st_size > MAX_FILE_BYTES:
            raise _refusal(path, "too large for a calibration")
        text = path.read_text()
    except (OSError, UnicodeDecodeError) as error:
        reason = getattr(error, "strerror", None) or "no text"
        raise UsageError(f"--camera-info {path}: {reason}") from error
    body = text.partition("---")[2] if text.startswith("%YAML") else text.removeprefix("---")
    flags = cv2.FILE_STORAGE_READ | cv2.FILE_STORAGE_MEMORY | cv2.FILE_STORAGE_FORMAT_YAML
    try:
        storage = cv2.FileStorage(HEADER + body.lstrip(), flags)
    except (cv2.error, SystemError) as error:  # its constructor raises the one as the other
        raise _refusal(path, "no YAML that OpenCV reads; lists stand in brackets") from error
    try:
        return _check(path, storage)
    finally:
        storage.release()


def write_camera_info(path: Path, info: CameraInfo, remark: str) -> None:
    """Write a calibration as ROS's camera_calibration does; raises UsageError."""
    projection = np.hstack([info.matrix, np.zeros((3, 1))])
    lines = [
        f"# {remark}",
        f"image_width: {info.width_px}",
        f"image_height: {info.height_px}",
        "camera_name: camera",
        *_matrix_lines("camera_matrix", info.matrix),
        f"distortion_model: {info.model}",
        *_matrix_lines("distortion_coefficients", info.coefficients[None]),
        *_matrix_lines("rectification_matrix", np.eye(3)),
        *_matrix_lines("projection_matrix", projection),
    ]
    try:
        write_whole(path, ("\n".join(lines) + "\n").encode())
    except OSError as error:
        raise UsageError(f"cannot write {path}: {error.strerror}") from error


def _matrix_lines(name: str, matrix: NDArray[np.float64]) -> list[str]:
    rows, columns = matrix.shape
    numbers = ", ".join(f"{value:.10g}" for value in matrix.ravel())
    return [f"{name}:", f"  rows: {rows}", f"  cols: {columns}", f"  data: [{numbers}]"]


def _check(path: Path, storage: Any) -> CameraInfo:
    width, height = (_number(path, storage, name) for name in ("image_width", "image_height"))
    matrix = _numbers(path, storage, "camera_matrix")
    coefficients = _numbers(path, storage, "distortion_coefficients")
    if not (1 <= width <= LARGEST_PX and 1 <= height <= LARGEST_PX):
        raise _refusal(path, f"image_width and image_height are {width:g} x {height:g}")
    if matrix.size != 9:
        raise _refusal(path, f"camera_matrix has {matrix.size} numbers, not 9")
    matrix = matrix.reshape(3, 3)
    if min(matrix[0, 0], matrix[1, 1]) <= 0 or not (
        0 < matrix[0, 2] < width and 0 < matrix[1, 2] < height
    ):
        raise _refusal(path, "camera_matrix is that of no camera of this size")
    named = storage.getNode("distortion_model")
    model = named.string() if named.isString() else BY_COUNT.get(coefficients.size, "plumb_bob")
    if coefficients.size not in MODELS.get(model, ()):
        raise _refusal(
            path,
            f"distortion_model {model} with {coefficients.size} coefficients; "
            f"known are {', '.join(MODELS)}",
        )
    return CameraInfo(
        width_px=round(width),
        height_px=round(height),
        matrix=matrix,
        model=model,
        coefficients=coefficients,
    )


def _number(path: Path, storage: Any, name: str) -> float:
    node = storage.getNode(name)
    if not (node.isInt() or node.isReal()):
        raise _refusal(path, f"{name} is missing")
    return float(node.real())


def _numbers(path: Path, storage: Any, name: str) -> NDArray[np.float64]:
    """Read ROS's map of rows, cols and data, or OpenCV's matrix, which looks the same inside."""
    data = storage.getNode(name).getNode("data") if storage.getNode(name).isMap() else None
    if data is None or not data.isSeq():
        raise _refusal(path, f"{name} with its data is missing")
    numbers = np.array([data.at(number).real() for number in range(data.size())], np.float64)
    if not np.isfinite(numbers).all():
        raise _refusal(path, f"{name} is not finite")
    return numbers


def _refusal(path: Path, why: str) -> UsageError:
    return UsageError(
        f"--camera-info {path}: {why}; `python -m flightstack.calibration chessboard` makes one"
    )
