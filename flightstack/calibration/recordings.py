"""Read images one after the other: from a folder of pictures, a video, or one picture."""

from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np

from flightstack.arrays import Rgb
from flightstack.errors import UsageError

PICTURES = (".png", ".jpg", ".jpeg")


def read_recording(path: Path) -> Iterator[Rgb]:
    """Give the images of a recording in order; raises UsageError where there are none."""
    found = False
    for bgr in _pictures(path) if _is_pictures(path) else _video(path):
        found = True
        yield np.asarray(cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB), np.uint8)
    if not found:
        raise UsageError(f"{path}: no images there; name a video, a picture or a folder of them")


def read_frames(folder: Path) -> Iterator[tuple[int, Rgb]]:
    """Give the images that the companion recorded, with their stamps, vehicle time in us."""
    paths = sorted(folder.glob("[0-9]" * 12 + ".png")) if folder.is_dir() else []
    if not paths:
        raise UsageError(f"{folder}: no recorded frames; fly or stand with --record-frames")
    for path in paths:
        bgr = cv2.imread(str(path), cv2.IMREAD_COLOR)
        if bgr is not None:
            yield int(path.stem), np.asarray(cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB), np.uint8)


def _is_pictures(path: Path) -> bool:
    return path.is_dir() or path.suffix.lower() in PICTURES


def _pictures(path: Path) -> Iterator[cv2.typing.MatLike]:
    for each in sorted(path.iterdir()) if path.is_dir() else [path]:
        if each.suffix.lower() in PICTURES:
            bgr = cv2.imread(str(each), cv2.IMREAD_COLOR)
            if bgr is not None:
                yield bgr


def _video(path: Path) -> Iterator[cv2.typing.MatLike]:
    if not path.is_file():
        return
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    capture = cv2.VideoCapture(str(path))
    try:
        while capture.isOpened():
            good, bgr = capture.read()
            if not good:
                return
            yield bgr
    finally:
        capture.release()
