"""A lens is found from pictures of a chessboard, well enough to see by."""

import itertools
from pathlib import Path

import cv2
import numpy as np
import pytest

from flightstack.arrays import Rgb
from flightstack.calibration.cli import main
from flightstack.camera.lens.camera_info import CameraInfo, read_camera_info, write_camera_info
from tests.lenses import FISHEYE, STRONG, Lens

COLUMNS, ROWS, SQUARE_PX = 9, 6, 40
SIDE_PX, FOCAL_PX = 1200, 300.0  # of the pinhole that draws: 127 degrees
SCALE = 3  # times the test lenses' pixels: a board needs some


def larger(info: CameraInfo) -> CameraInfo:
    matrix = info.matrix.copy()
    matrix[:2, 2] += 0.5
    matrix[:2] *= SCALE
    matrix[:2, 2] -= 0.5
    return CameraInfo(
        width_px=info.width_px * SCALE,
        height_px=info.height_px * SCALE,
        matrix=matrix,
        model=info.model,
        coefficients=info.coefficients,
    )


def board() -> Rgb:
    rows, columns = np.indices(((ROWS + 3) * SQUARE_PX, (COLUMNS + 3) * SQUARE_PX)) // SQUARE_PX
    dark = (rows + columns) % 2 == 1
    dark[(rows == 0) | (columns == 0) | (rows == ROWS + 2) | (columns == COLUMNS + 2)] = False
    return np.repeat(np.where(dark, 20, 235).astype(np.uint8)[..., None], 3, axis=2)


def seen_at(shift: tuple[float, float, float], tilt: tuple[float, float]) -> Rgb:
    """Draw the board a little way ahead of the pinhole: right, down, forward in its own widths."""
    picture = board()
    height, width = picture.shape[:2]
    turn, _ = cv2.Rodrigues(np.array([*tilt, 0.1]))
    flat = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
    flat[:, 1] *= height / width
    there = np.column_stack([flat, np.zeros(4)]) @ turn.T + np.array(shift)
    pixels = there[:, :2] / there[:, 2:] * FOCAL_PX + (SIDE_PX - 1) / 2
    corners = np.array([[0, 0], [width, 0], [width, height], [0, height]], np.float32)
    way = cv2.getPerspectiveTransform(corners, pixels.astype(np.float32))
    drawn = cv2.warpPerspective(
        picture, way, (SIDE_PX, SIDE_PX), flags=cv2.INTER_AREA, borderValue=(120, 120, 120)
    )
    return np.asarray(drawn, np.uint8)


def write_recording(folder: Path, info: CameraInfo) -> None:
    lens = Lens(info, SIDE_PX, focal_px=FOCAL_PX)
    folder.mkdir()
    places = [(*at, 0.85) for at in itertools.product((-0.55, 0.0, 0.55), (-0.35, 0.0, 0.35))]
    places += [(0.0, 0.0, 0.5), (-0.12, 0.1, 0.5), (0.12, -0.1, 0.5)]
    tilts = itertools.cycle([(0.35, -0.3), (-0.3, 0.4), (0.2, 0.3), (-0.35, -0.2)])
    for number, (place, tilt) in enumerate(zip(places, tilts, strict=False)):
        cv2.imwrite(str(folder / f"{number:04d}.png"), lens(seen_at(place, tilt))[..., ::-1])


def pixels_of(info: CameraInfo) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Where rays through the whole of the networks' view land."""
    steps = np.linspace(-0.8, 0.8, 7)
    rays = np.stack([*np.meshgrid(steps, steps), np.ones((7, 7))], axis=-1).reshape(-1, 1, 3)
    project = cv2.fisheye.projectPoints if info.model == "equidistant" else cv2.projectPoints
    pixels, _ = project(rays, np.zeros(3), np.zeros(3), info.matrix, info.coefficients)
    return np.asarray(pixels, np.float64).reshape(-1, 2)


@pytest.mark.parametrize("true", [larger(STRONG), larger(FISHEYE)], ids=lambda info: info.model)
def test_a_strong_lens_is_found(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], true: CameraInfo
) -> None:
    write_recording(tmp_path / "board", true)
    output = tmp_path / "camera.yaml"
    options = [f"--lens={true.model}", f"--output={output}"]
    assert main(["chessboard", str(tmp_path / "board"), *options]) == 0
    said = capsys.readouterr().out
    found = read_camera_info(output)
    assert f"{true.width_px} x {true.height_px} pixels" in said
    assert (found.width_px, found.model) == (true.width_px, true.model)
    off_px = np.linalg.norm(pixels_of(found) - pixels_of(true), axis=1)
    assert np.median(off_px) < 1.0  # of 170 to 210 pixels of focal length: 0.3 degrees
    assert off_px.max() < 3.0


def test_too_few_boards_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "nothing"
    folder.mkdir()
    cv2.imwrite(str(folder / "0.png"), np.zeros((48, 64, 3), np.uint8))
    assert main(["chessboard", str(folder)]) == 2
    error = capsys.readouterr().err
    assert "9 x 6 inner corners is seen in 0 images" in error
    assert main(["chessboard", str(tmp_path / "none.mp4")]) == 2
    assert "none.mp4: no images there" in capsys.readouterr().err
    assert main(["chessboard", str(folder), "--rows=1"]) == 2


def test_what_the_networks_see_is_drawn(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    picture = tmp_path / "picture.png"
    cv2.imwrite(str(picture), np.full((120, 160, 3), 90, np.uint8))
    info, output = tmp_path / "camera.yaml", tmp_path / "view.png"
    write_camera_info(info, STRONG, "a test")
    options = [f"--camera-info={info}", f"--output={output}"]
    assert main(["view", str(picture), *options]) == 0
    assert "100 % of them shown" in capsys.readouterr().out
    drawn = cv2.imread(str(output))
    assert drawn is not None
    assert drawn.shape == (512, 683 + 8 + 512, 3)
    assert (drawn[256, 900] == 90).all()
    assert main(["view", str(picture), f"--output={tmp_path / 'none' / 'view.png'}"]) == 2
    assert "cannot write" in capsys.readouterr().err
