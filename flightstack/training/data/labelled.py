"""Images that a person has labelled: the corners of the gate's opening become where the gate is.

A CSV file has a row an image: its path, and the four corners in pixels from the image's upper left,
clockwise from the upper left one; of a round opening its top, right, bottom and left. A gate stands
upright, so that its own axes tell how far the camera is tilted.
"""

import csv
import hashlib
import math
from collections.abc import Iterator
from dataclasses import asdict
from pathlib import Path

import cv2
import numpy as np
from jaxtyping import Float64
from numpy.typing import NDArray

from flightstack.arrays import Labels, Rgb
from flightstack.errors import UsageError
from flightstack.perception.labels import LABELS
from flightstack.perception.preprocessing import fit_image
from flightstack.training.data.manifest import refuse_other, settings_sha256, write_manifest
from flightstack.training.data.shards import write_shard
from flightstack.training.recipe import Recipe
from sitl import GateShape

COLUMNS = ("image", "x1", "y1", "x2", "y2", "x3", "y3", "x4", "y4")
TRAIN_SHARE = 0.8  # the first of them: what follows is another part of the recording
SHARDS = (("train-00000", "train"), ("validation-00000", "validation"))
MIN_IMAGES = 5
EQUALLY_GOOD = 2.0  # times the smallest error of reprojection
SLACK = 2e-3  # of a tangent: a person's click
METHODS = (cv2.SOLVEPNP_IPPE, cv2.SOLVEPNP_SQPNP)  # both turns of a plane; and one that never fails
Corners = Float64[NDArray[np.float64], "4 2"]


def read_labelled(file: Path, folder: Path, recipe: Recipe, out: Path) -> Path:
    """Make a dataset of labelled images in `out`, by the recipe's gate and field of view.

    Images of any size are cut and shrunk as in flight. Raises UsageError, in one line, for a file
    that cannot be read, a row or an image that cannot be, and a folder that holds other data.
    """
    rows = _read_rows(file)
    scenery = recipe.views.scenery
    tangent = math.tan(math.radians(scenery.field_of_view_deg) / 2.0)
    images, labels = [], []
    for number, (name, corners) in enumerate(rows, start=2):
        where = f"{file}, line {number}"
        rgb = _read_image(folder / name, where)
        images.append(fit_image(rgb))
        labels.append(_label(corners, rgb, tangent, scenery.gate, where))
    about = {
        "kind": "labelled",
        "recipe": recipe.name,
        "seed": 0,
        "settings": {
            "labels_sha256": hashlib.sha256(file.read_bytes()).hexdigest(),
            "images_sha256": hashlib.sha256(np.stack(images).data).hexdigest(),
            "scenery": asdict(scenery),
        },
    }
    out.mkdir(parents=True, exist_ok=True)
    refuse_other(out, about, {})
    _write(out, np.stack(images), np.stack(labels), settings_sha256(about))
    write_manifest(out, [name for name, _ in SHARDS], label_names=LABELS, about=about)
    return out


def pose_of(tangents: Corners, shape: GateShape) -> Float64[NDArray[np.float64], "4"]:
    """Say where a gate is of which the opening's corners are seen: a row of `LABELS`.

    `tangents` are right and down over forward, in the camera's axes. Raises ValueError where no
    gate can be seen so. Reference: Collins and Bartoli 2014, "Infinitesimal plane-based pose".
    """
    half = shape.inner_m / 2.0
    square = np.array([[-half, -half], [half, -half], [half, half], [-half, half]])
    diamond = np.array([[0.0, -half], [half, 0.0], [0.0, half], [-half, 0.0]])
    flat = diamond if shape.outline == "circle" else square
    found = [each for method in METHODS for each in _poses(flat, tangents, method)]
    if not found:
        raise ValueError("no gate can be seen so: corners go clockwise from the upper left")
    most = EQUALLY_GOOD * min(error for error, _, _ in found) + SLACK
    good = [(axes, place) for error, axes, place in found if error <= most]
    axes, place = max(good, key=lambda each: each[0][1, 1])  # the camera tilts least under it
    right, down, ahead = place
    distance_m = float(np.linalg.norm(place))
    return np.array(
        [distance_m, math.atan2(right, ahead), math.asin(-down / distance_m), _yaw(axes)]
    )


def _poses(
    flat: Corners, tangents: Corners, method: int
) -> Iterator[tuple[float, NDArray[np.float64], NDArray[np.float64]]]:
    """Yield errors of reprojection, axes and places of gates that are seen like this."""
    solid = np.column_stack([flat, np.zeros(4)])
    _, turns, places, errors = cv2.solvePnPGeneric(solid, tangents, np.eye(3), None, flags=method)
    for turn, place, error in zip(turns, places, np.ravel(errors), strict=True):
        axes = np.asarray(cv2.Rodrigues(turn)[0], np.float64)
        if place[2, 0] > 0.0 and np.isfinite(axes).all():
            yield float(error), axes, np.asarray(place[:, 0], np.float64)


def _yaw(axes: NDArray[np.float64]) -> float:
    """Turn of the gate's axis from the camera's, about the vertical, clockwise from above."""
    down, axis = axes[:, 1], axes[:, 2]
    ahead = np.array([0.0, 0.0, 1.0]) - down[2] * down
    return math.atan2(float(down @ np.cross(ahead, axis)), float(ahead @ axis))


def _label(
    corners: Corners, rgb: Rgb, tangent: float, shape: GateShape, where: str
) -> NDArray[np.float32]:
    height, width, _ = rgb.shape
    side = min(height, width)
    cut = corners - [(width - side) // 2, (height - side) // 2]
    try:
        pose = pose_of((cut / side * 2.0 - 1.0) * tangent, shape)
    except (ValueError, cv2.error) as error:
        raise UsageError(f"{where}: {str(error).splitlines()[0]}") from error
    return np.asarray(pose, dtype=np.float32)


def _write(out: Path, images: NDArray[np.uint8], labels: Labels, settings: str) -> None:
    train = min(round(TRAIN_SHARE * len(images)), len(images) - 1)
    parts = (slice(0, train), slice(train, None))
    for (name, split), part in zip(SHARDS, parts, strict=True):
        write_shard(out, name, split, images[part], labels[part], settings_sha256=settings)


def _read_rows(file: Path) -> list[tuple[str, Corners]]:
    try:
        with file.open(newline="") as text:
            reader = csv.DictReader(text)
            if tuple(reader.fieldnames or ()) != COLUMNS:
                raise UsageError(f"{file}: the first line must be {','.join(COLUMNS)}")
            rows = [_row(row, f"{file}, line {number}") for number, row in enumerate(reader, 2)]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise UsageError(f"{file}: can't be read: {error}") from error
    if len(rows) < MIN_IMAGES:
        raise UsageError(f"{file}: {len(rows)} images; label {MIN_IMAGES} or more")
    return rows


def _row(row: dict[str, str], where: str) -> tuple[str, Corners]:
    try:
        corners = np.array([float(row[name]) for name in COLUMNS[1:]]).reshape(4, 2)
    except (TypeError, ValueError) as error:
        raise UsageError(f"{where}: expected eight numbers after the image") from error
    if not np.isfinite(corners).all():
        raise UsageError(f"{where}: a corner is not finite")
    return row["image"], corners


def _read_image(path: Path, where: str) -> Rgb:
    image = cv2.imread(str(path), cv2.IMREAD_COLOR) if path.is_file() else None
    if image is None:
        raise UsageError(f"{where}: {path} is no image that can be read")
    return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2RGB), dtype=np.uint8)
