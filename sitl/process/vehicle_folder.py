"""A folder for one vehicle's files, gone when it ends; a killed vehicle's goes at a later start.

A vehicle holds a lock on its folder, and the system lets go of it however the vehicle ends.
"""

import contextlib
import fcntl
import os
import shutil
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

PREFIX = "flightstack-vehicle-"
YOUNG_S = 60.0  # a folder younger than this may not be locked yet


@contextlib.contextmanager
def vehicle_folder(parent: Path | None = None) -> Iterator[Path]:
    """Make a folder, by default among the system's temporary ones."""
    place = parent or Path(tempfile.gettempdir())
    sweep(place, time.time())
    with tempfile.TemporaryDirectory(prefix=PREFIX, dir=place) as name, _locked(Path(name)):
        yield Path(name)


def sweep(place: Path, now_s: float) -> None:
    """Remove the folders that vehicles of this user have left behind."""
    for folder in place.glob(f"{PREFIX}*"):
        with contextlib.suppress(OSError):  # somebody else removes it, or holds it
            about = folder.lstat()
            if about.st_uid != os.getuid() or now_s - about.st_mtime < YOUNG_S:
                continue
            with _locked(folder):
                shutil.rmtree(folder, ignore_errors=True)


@contextlib.contextmanager
def _locked(folder: Path) -> Iterator[None]:
    """Hold the folder's lock; raises OSError where another holds it, or it is no folder."""
    handle = os.open(folder, os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield
    finally:
        os.close(handle)
