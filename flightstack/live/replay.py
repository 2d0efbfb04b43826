"""Draw a log that is whole, with its recorded images."""

from pathlib import Path

import numpy as np

from flightstack.camera.parts import decode_rgb
from flightstack.live.scene.drawing import FlightDrawing
from flightstack.logs.columns.log import Log

IMAGES = "[0-9]" * 12 + ".png"  # named by their stamp, us of vehicle time


def draw_log(drawing: FlightDrawing, log: Log, folder: Path) -> int:
    """Draw all of it; the number of images."""
    drawing.draw(log)
    count = 0
    for path in sorted(folder.glob(IMAGES)):
        rgb = decode_rgb(path.read_bytes())
        if rgb is not None:
            drawing.draw_image(int(path.stem), np.asarray(rgb, np.uint8))
            count += 1
    return count
