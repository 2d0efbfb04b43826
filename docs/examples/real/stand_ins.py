"""Make stand-ins for labelled images of a real gate: rendered, under a look of their own.

    python docs/examples/real/stand_ins.py --recipe ring.toml --images 200 --out real

Writes real/000000.png, ... and real/corners.csv, as a person with a camera and patience would.
"""

import argparse
import csv
import math
from pathlib import Path

import cv2
import numpy as np

from flightstack.training.data.gate_views import place
from flightstack.training.recipe import Recipe
from sitl import Camera, Gate, draw_look, quaternion_from_euler, rotate

RANGE_M, AZIMUTH, ELEVATION, YAW, TILT = (1.2, 6.0), 0.35, 0.25, 0.6, 0.2  # rad, either way
BLUR_PX, NOISE = 0.6, 4.0


def main() -> None:
    """Render, and say where the corners of the opening are."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--recipe", default="strong")
    parser.add_argument("--images", type=int, default=200)
    parser.add_argument("--out", type=Path, default=Path("real"))
    options = parser.parse_args()
    scenery, rng = Recipe.load(options.recipe).views.scenery, np.random.default_rng(2026)
    half, eye = scenery.gate.inner_m / 2.0, (0.0, 0.0, -2.0)
    square = ((-half, -half), (half, -half), (half, half), (-half, half))
    diamond = ((0.0, -half), (half, 0.0), (0.0, half), (-half, 0.0))
    corners = diamond if scenery.gate.outline == "circle" else square
    options.out.mkdir(parents=True, exist_ok=True)
    with (options.out / "corners.csv").open("w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["image", *(f"{axis}{k}" for k in range(1, 5) for axis in "xy")])
        for number in range(options.images):
            tilt, yaw = rng.uniform(-TILT, TILT, 2), float(rng.uniform(-math.pi, math.pi))
            attitude = quaternion_from_euler(float(tilt[0]), float(tilt[1]), yaw)
            bearing = (float(rng.uniform(-AZIMUTH, AZIMUTH)), float(rng.uniform(0.0, ELEVATION)))
            centre = place(eye, attitude, float(rng.uniform(*RANGE_M)), *bearing)
            turn = yaw + float(rng.uniform(-YAW, YAW))
            gate = Gate(index=0, centre_ned=centre, yaw_rad=turn, shape=scenery.gate)
            field = scenery.field_of_view_deg
            camera = Camera((gate,), draw_look(rng, scenery), field_of_view_deg=field)
            seen = cv2.GaussianBlur(camera.render(eye, attitude), (0, 0), BLUR_PX)
            camera.close()
            seen = np.clip(seen + rng.normal(0.0, NOISE, seen.shape), 0, 255).astype(np.uint8)
            cv2.imwrite(str(options.out / f"{number:06}.png"), seen[:, :, ::-1])
            row, (w, x, y, z) = [f"{number:06}.png"], attitude
            for right, down in corners:
                point = [c - e for c, e in zip(centre, eye, strict=True)]
                point[0] -= right * math.sin(turn)
                point[1] += right * math.cos(turn)
                ahead, to_right, below = rotate(
                    (w, -x, -y, -z), (point[0], point[1], point[2] + down)
                )
                reach = math.tan(math.radians(field) / 2.0) * ahead
                row += [f"{(part / reach + 1.0) * 32.0:.3f}" for part in (to_right, below)]
            table.writerow(row)


if __name__ == "__main__":
    main()
