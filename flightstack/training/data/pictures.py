"""Show a dataset to a person: a sheet of images with their labels drawn in, and histograms.

Gate poses: a ring where the gate's centre is said to be, and an arrow along its passing axis, drawn
as if the camera flew level. Commands: seen from above, an arrow ahead (vx) and to the side (vy), a
bar for climbing or sinking (vz), and a bar at the bottom for the yaw rate, each 1 at full length.
"""

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from flightstack.errors import UsageError
from flightstack.libraries import load_pyplot
from flightstack.perception.labels import LABELS
from flightstack.policy.scales import VelocityRange
from flightstack.records import VELOCITIES
from flightstack.training.data.dataset import Dataset, read_dataset

ROWS, COLUMNS, ZOOM = 5, 6, 4
SIDE = 64 * ZOOM  # pixels of one image on the sheet
FIELD_OF_VIEW_DEG = 90.0  # where a dataset names no other
AXIS_M = 1.0  # length of the arrow along the gate's axis
RING, ARROW, CLIMB, TURN = (255, 230, 0), (255, 60, 60), (60, 220, 60), (80, 160, 255)
NEAREST_M = 0.05  # before the camera, that an arrow may reach

Draw = Callable[[NDArray[np.uint8], NDArray[np.float32]], None]


def write_pictures(
    folder: Path, out: Path, *, seed: int, report: Callable[[str], None] = print
) -> None:
    """Write `sheet.png` and `histograms.png` of the dataset in `folder`.

    Raises UsageError when there is none, or when its labels are of a kind that cannot be drawn.
    """
    dataset = read_dataset(folder)
    scenery = dataset.manifest.get("settings", {}).get("scenery", {})
    half_deg = scenery.get("field_of_view_deg", FIELD_OF_VIEW_DEG) / 2.0
    seen = partial(draw_pose, reach=math.tan(math.radians(half_deg)))
    known: dict[tuple[str, ...], Draw] = {LABELS: seen, VELOCITIES: draw_command}
    draw = known.get(dataset.label_names)
    if draw is None:
        raise UsageError(f"{folder}: labels {', '.join(dataset.label_names)} cannot be drawn")
    out.mkdir(parents=True, exist_ok=True)
    sheet = draw_sheet(dataset, draw, seed)
    cv2.imwrite(str(out / "sheet.png"), cv2.cvtColor(sheet, cv2.COLOR_RGB2BGR))
    draw_histograms(dataset, out / "histograms.png")
    report(f"wrote {out / 'sheet.png'} and {out / 'histograms.png'}")


def draw_sheet(dataset: Dataset, draw: Draw, seed: int) -> NDArray[np.uint8]:
    """Draw labelled images, chosen at random, as one picture (ROWS SIDE, COLUMNS SIDE, 3)."""
    count = min(ROWS * COLUMNS, len(dataset.images))
    chosen = np.sort(np.random.default_rng(seed).choice(len(dataset.images), count, replace=False))
    sheet = np.zeros((ROWS * SIDE, COLUMNS * SIDE, 3), dtype=np.uint8)
    for k, image in enumerate(dataset.images[chosen]):
        picture = cv2.resize(image, (SIDE, SIDE), interpolation=cv2.INTER_NEAREST)
        draw(picture, dataset.labels[chosen[k]])
        row, column = divmod(k, COLUMNS)
        sheet[row * SIDE : (row + 1) * SIDE, column * SIDE : (column + 1) * SIDE] = picture
    return sheet


def draw_pose(
    picture: NDArray[np.uint8], label: NDArray[np.float32], *, reach: float = 1.0
) -> None:
    """Draw a gate pose (4,) into a picture (SIDE, SIDE, 3); `reach`: tangent at its edge."""
    range_m, azimuth, elevation, gate_yaw = (float(value) for value in label)
    ahead = np.cos(elevation)
    ray = np.array([ahead * np.cos(azimuth), ahead * np.sin(azimuth), -np.sin(elevation)])
    centre = range_m * ray
    axis = np.array([np.cos(gate_yaw), np.sin(gate_yaw), 0.0])
    at, tip = pixel(centre, reach), pixel(centre + AXIS_M * axis, reach)
    cv2.arrowedLine(picture, at, tip, ARROW, 2, tipLength=0.3)
    cv2.circle(picture, at, 5, RING, 2)


def draw_command(picture: NDArray[np.uint8], label: NDArray[np.float32]) -> None:
    """Draw a command (4,) into a picture (SIDE, SIDE, 3)."""
    limits = VelocityRange().high
    vx, vy, vz, yaw_rate = (
        float(np.clip(v / m, -1.0, 1.0)) * SIDE / 2 for v, m in zip(label, limits, strict=True)
    )
    middle, right, bottom = SIDE // 2, SIDE - 12, SIDE - 12
    tip = (round(middle + vy), round(middle - vx))
    cv2.arrowedLine(picture, (middle, middle), tip, ARROW, 2, tipLength=0.2)
    cv2.line(picture, (right, middle), (right, round(middle + vz)), CLIMB, 6)
    cv2.line(picture, (middle, bottom), (round(middle + yaw_rate), bottom), TURN, 6)


def pixel(point: NDArray[np.float64], reach: float = 1.0) -> tuple[int, int]:
    """Where a point (3,), body FRD, stands in a picture that reaches so far, as a tangent."""
    forward, right, down = point[0], point[1], point[2]
    scale = SIDE / 2 / reach / max(forward, NEAREST_M)
    at = np.clip(SIDE / 2 + scale * np.array([right, down]), -SIDE, 2 * SIDE)
    return round(at[0]), round(at[1])


def draw_histograms(dataset: Dataset, path: Path) -> None:
    """Write one histogram a label, the splits over each other."""
    plt = load_pyplot("training")
    figure, axes = plt.subplots(2, 2, figsize=(10, 7), layout="constrained")
    for k, (name, plot) in enumerate(zip(dataset.label_names, axes.flat, strict=True)):
        edges = np.histogram_bin_edges(dataset.labels[:, k], bins=60)
        for split, indices in dataset.splits.items():
            plot.hist(dataset.labels[indices, k], edges, density=True, histtype="step", label=split)
        plot.set(xlabel=name, ylabel="density")
    axes.flat[0].legend()
    figure.suptitle(f"{dataset.folder.name}: {len(dataset.images)} images")
    figure.savefig(path)
    plt.close(figure)
