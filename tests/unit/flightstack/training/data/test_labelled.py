"""A gate's corners in an image become where it is, or one line says which row cannot be."""

import math
from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from flightstack.errors import UsageError
from flightstack.perception.labels import LABELS
from flightstack.training.data.dataset import read_dataset
from flightstack.training.data.gate_views import place
from flightstack.training.data.labelled import COLUMNS, pose_of, read_labelled
from flightstack.training.recipe import Recipe
from sitl import GateShape, quaternion_from_euler, rotate, wrap_pi

EYE = (0.0, 0.0, -5.0)
SQUARE = ((-1, -1), (1, -1), (1, 1), (-1, 1))
ROUND = ((0, -1), (1, 0), (0, 1), (-1, 0))
STRONG = Recipe.load("strong")
ROW = "a.png,200,100,440,100,440,340,200,340"


def tangents(
    pose: tuple[float, float, float, float], tilt: tuple[float, float], shape: GateShape
) -> NDArray[np.float64]:
    """Where a camera that is tilted by roll and pitch sees the corners of a gate's opening."""
    range_m, azimuth, elevation, gate_yaw = pose
    attitude = quaternion_from_euler(*tilt, 1.0)
    centre, turn = place(EYE, attitude, range_m, azimuth, elevation), 1.0 + gate_yaw
    w, x, y, z = attitude
    seen = []
    for right, down in SQUARE if shape.outline == "square" else ROUND:
        half = shape.inner_m / 2.0
        north, east, below = (c - e for c, e in zip(centre, EYE, strict=True))
        north -= right * half * math.sin(turn)
        east += right * half * math.cos(turn)
        ahead, to_right, under = rotate((w, -x, -y, -z), (north, east, below + down * half))
        seen.append((to_right / ahead, under / ahead))
    return np.array(seen)


@given(
    st.floats(1.0, 8.0), st.floats(-0.6, 0.6), st.floats(-0.5, 0.5), st.floats(-1.0, 1.0),
    st.floats(-0.2, 0.2), st.floats(-0.2, 0.2), st.sampled_from(["square", "circle"]),
)  # fmt: skip
def test_exact_corners_give_the_pose_back(
    range_m: float, azimuth: float, elevation: float, yaw: float,
    roll: float, pitch: float, outline: str,
) -> None:  # fmt: skip
    shape = GateShape(outline="square" if outline == "square" else "circle")
    corners = tangents((range_m, azimuth, elevation, yaw), (roll, pitch), shape)
    found = pose_of(corners, shape)
    assert found[:3] == pytest.approx([range_m, azimuth, elevation], rel=0.03, abs=0.01)
    # Far away and nearly face on, two turns of a plane look alike: the wrong one is the mirror's.
    if range_m < 4.0 and abs(yaw) > 0.3:
        assert abs(wrap_pi(float(found[3]) - yaw)) < 0.15


def test_a_dataset_is_made_of_images_of_any_size(tmp_path: Path) -> None:
    image = np.full((480, 640, 3), 90, np.uint8)
    cv2.imwrite(str(tmp_path / "a.png"), image)
    table = tmp_path / "corners.csv"
    table.write_text("\n".join([",".join(COLUMNS), *[ROW] * 10]))
    data = read_dataset(read_labelled(table, tmp_path, STRONG, tmp_path / "out"))
    assert data.label_names == LABELS
    assert [len(data.splits[name]) for name in ("train", "validation")] == [8, 2]
    # 240 of 480 pixels wide, 90 degrees: an opening of 1.2 m at 1.2 m; its middle 20 px above
    distance, azimuth, elevation, yaw = data.labels[0]
    assert azimuth == pytest.approx(0.0, abs=1e-3)
    assert distance * math.cos(elevation) == pytest.approx(1.2, rel=1e-3)
    assert elevation == pytest.approx(math.atan(20 / 240), abs=1e-3)
    assert yaw == pytest.approx(0.0, abs=1e-2)
    table.write_text("\n".join([",".join(COLUMNS), *[ROW.replace("440", "430")] * 10]))
    with pytest.raises(UsageError, match="holds data made with another"):
        read_labelled(table, tmp_path, STRONG, tmp_path / "out")


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("image,u,v\n", "the first line must be image,x1,y1"),
        (",".join(COLUMNS) + f"\n{ROW}\n", "1 images; label 5 or more"),
        (",".join(COLUMNS) + "\na.png,1,2,3\n", "line 2: expected eight numbers"),
        (",".join(COLUMNS) + "\n" + ROW.replace("340", "nan"), "line 2: a corner is not finite"),
        (",".join(COLUMNS) + ("\n" + ROW.replace("a.png", "b.png")) * 5, r"b\.png is no image"),
    ],
)
def test_a_row_that_cannot_be_is_named(text: str, match: str, tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "a.png"), np.zeros((480, 640, 3), np.uint8))
    (tmp_path / "corners.csv").write_text(text)
    with pytest.raises(UsageError, match=match) as refusal:
        read_labelled(tmp_path / "corners.csv", tmp_path, STRONG, tmp_path / "out")
    assert "\n" not in str(refusal.value)
