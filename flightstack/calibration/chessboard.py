"""Calibrate a lens from images of a flat chessboard (Zhang 2000, in OpenCV's calibrateCamera)."""

from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import numpy as np
from jaxtyping import Float32
from numpy.typing import NDArray

from flightstack.arrays import Rgb
from flightstack.camera.lens.camera_info import CameraInfo
from flightstack.errors import UsageError

MAX_BOARDS, MIN_BOARDS = 40, 8
MIN_MOVED = 0.01  # of the image's width, on average over corners: less is the same board again
OUTLIER = 3.0  # times the median error: a board that was moved or bent while it was seen
FLAGS = {"plumb_bob": 0, "rational_polynomial": cv2.CALIB_RATIONAL_MODEL}
COUNTS = {"plumb_bob": 5, "rational_polynomial": 8}
SEARCH = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_ACCURACY

Corners = Float32[NDArray[np.float32], "P 1 2"]  # pixels


@dataclass(frozen=True, slots=True, kw_only=True)
class LensFit:
    """A calibration, and what it stands on."""

    info: CameraInfo
    error_px: float  # root mean square over all corners that were used
    boards: int
    seen: int  # images in which a board was found
    spread: tuple[float, float]  # share of the image's width and height that boards covered


def calibrate(images: Iterable[Rgb], columns: int, rows: int, model: str) -> LensFit:
    """Fit a lens to boards of `columns` x `rows` inner corners; UsageError where they are too few.

    The squares' size does not matter: only the board's pose would change with it.
    """
    found, size = _find_boards(images, columns, rows)
    boards = _apart(found, size[0])
    if len(boards) < MIN_BOARDS:
        raise UsageError(
            f"a chessboard of {columns} x {rows} inner corners is seen in {len(found)} images, in "
            f"{len(boards)} different places: show it in {MIN_BOARDS} or more, tilted, up to the "
            "edges of the image; count corners between squares"
        )
    matrix, coefficients, errors = _fit(boards, (columns, rows), size, model)
    kept = [b for b, e in zip(boards, errors, strict=True) if e <= OUTLIER * np.median(errors)]
    if MIN_BOARDS <= len(kept) < len(boards):
        boards = kept
        matrix, coefficients, errors = _fit(boards, (columns, rows), size, model)
    corners = np.concatenate(boards)[:, 0]
    across, down = np.ptp(corners, axis=0) / size
    return LensFit(
        info=CameraInfo(
            width_px=size[0],
            height_px=size[1],
            matrix=matrix,
            model=model,
            coefficients=coefficients,
        ),
        error_px=float(np.sqrt(np.mean(np.square(errors)))),
        boards=len(boards),
        seen=len(found),
        spread=(float(across), float(down)),
    )


def _find_boards(
    images: Iterable[Rgb], columns: int, rows: int
) -> tuple[list[Corners], tuple[int, int]]:
    """Look for the board; return its corners in each image that shows it, and the images' size."""
    found: list[Corners] = []
    size = (0, 0)
    for rgb in images:
        if size == (0, 0):
            size = (rgb.shape[1], rgb.shape[0])
        if size != (rgb.shape[1], rgb.shape[0]):
            raise UsageError(f"images of {size} and of {rgb.shape[1::-1]} pixels in one recording")
        grey = cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY)
        good, corners = cv2.findChessboardCornersSB(grey, (columns, rows), flags=SEARCH)
        if good:
            found.append(np.asarray(corners, np.float32).reshape(-1, 1, 2))
    return found, size


def _apart(found: list[Corners], width_px: int) -> list[Corners]:
    """Choose boards that differ most from those chosen before, until none differs enough."""
    chosen = found[:1]
    while found and len(chosen) < MAX_BOARDS:
        moved = [min(_distance(board, other) for other in chosen) for board in found]
        if max(moved) < MIN_MOVED * width_px:
            break
        chosen.append(found[int(np.argmax(moved))])
    return chosen


def _distance(board: Corners, other: Corners) -> float:
    return float(np.linalg.norm(board - other, axis=2).mean())


def _fit(
    boards: list[Corners], shape: tuple[int, int], size: tuple[int, int], model: str
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return matrix, coefficients, and each board's error in pixels; UsageError where none fits."""
    grid = np.zeros((shape[0] * shape[1], 1, 3), np.float32)
    grid[:, 0, :2] = np.mgrid[: shape[0], : shape[1]].T.reshape(-1, 2)
    try:
        if model == "equidistant":
            return _fit_fisheye(boards, grid, size)
        found = cv2.calibrateCameraExtended(
            [grid] * len(boards), boards, size, np.eye(3), np.zeros(5), flags=FLAGS[model]
        )
    except cv2.error as error:
        raise UsageError(
            f"no {model} lens fits these boards: show more of them, tilted, or try another --lens"
        ) from error
    matrix, coefficients, errors = (np.asarray(found[n], np.float64) for n in (1, 2, 7))
    return matrix, coefficients.ravel()[: COUNTS[model]], errors.ravel()


def _fit_fisheye(
    boards: list[Corners], grid: NDArray[np.float32], size: tuple[int, int]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    focal_px = max(size) / np.pi  # half a turn across the image: a place to begin
    matrix = np.array(
        [[focal_px, 0, (size[0] - 1) / 2], [0, focal_px, (size[1] - 1) / 2], [0, 0, 1.0]]
    )
    coefficients = np.zeros((4, 1))
    points = grid.astype(np.float64).reshape(1, -1, 3)
    flags = cv2.CALIB_USE_INTRINSIC_GUESS | cv2.CALIB_RECOMPUTE_EXTRINSIC | cv2.CALIB_FIX_SKEW
    _, _, _, turns, shifts = cv2.fisheye.calibrate(
        [points] * len(boards),
        [board.astype(np.float64).reshape(1, -1, 2) for board in boards],
        size,
        matrix,
        coefficients,
        flags=flags,
    )
    errors = []
    for board, turn, shift in zip(boards, turns, shifts, strict=True):
        drawn, _ = cv2.fisheye.projectPoints(points, turn, shift, matrix, coefficients)
        errors.append(np.sqrt(np.mean(np.sum((drawn.reshape(-1, 1, 2) - board) ** 2, axis=2))))
    return matrix, coefficients.ravel(), np.array(errors)
