"""The vehicle's own folder, as others may read it: nothing outside it, and nothing changed.

A path is walked part by part from the folder itself, and no link is followed on the way, so
neither "..", nor a symbolic link, nor one that is put there in between leads out. "/" is the
folder itself.
"""

import os
import stat
from contextlib import ExitStack, suppress
from pathlib import Path

MAX_PATH_PARTS = 8
FOLDER_FLAGS = os.O_RDONLY | os.O_DIRECTORY | os.O_NOFOLLOW | os.O_CLOEXEC
FILE_FLAGS = os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC  # never wait for a pipe


class ForbiddenPathError(Exception):
    """A path that leads, or tries to lead, out of the folder."""


class VehicleFiles:
    """Read access to one folder; without a folder nothing is found."""

    def __init__(self, root: Path | None) -> None:
        self._root = root

    def open(self, path: str) -> int:
        """Open a regular file; the caller closes the descriptor.

        Raises:
            ForbiddenPathError: the path would leave the folder.
            FileNotFoundError: there is no such file.

        """
        parts = _parts(path)
        if not parts:
            raise FileNotFoundError(path)
        with ExitStack() as stack:
            folder = self._enter(parts[:-1], stack)
            descriptor = _open(parts[-1], FILE_FLAGS, folder)
        if not stat.S_ISREG(os.fstat(descriptor).st_mode):
            os.close(descriptor)
            raise FileNotFoundError(path)
        return descriptor

    def entries(self, path: str) -> list[tuple[str, int | None]]:
        """Name what is in a folder, sorted: files with their size, folders with None.

        Raises: as `open`.

        """
        found: list[tuple[str, int | None]] = []
        with ExitStack() as stack:
            folder = self._enter(_parts(path), stack)
            for name in sorted(os.listdir(folder)):  # noqa: PTH208  of a descriptor
                with suppress(OSError):  # it went away before we looked
                    status = os.stat(name, dir_fd=folder, follow_symlinks=False)
                    if stat.S_ISDIR(status.st_mode):
                        found.append((name, None))
                    elif stat.S_ISREG(status.st_mode):
                        found.append((name, status.st_size))
        return found

    def _enter(self, parts: list[str], stack: ExitStack) -> int:
        if self._root is None:
            raise FileNotFoundError
        folder = _open(str(self._root), FOLDER_FLAGS, None)
        stack.callback(os.close, folder)
        for part in parts:
            folder = _open(part, FOLDER_FLAGS, folder)
            stack.callback(os.close, folder)
        return folder


def _parts(path: str) -> list[str]:
    parts = [part for part in path.split("/") if part not in ("", ".")]
    if ".." in parts or "\0" in path or len(parts) > MAX_PATH_PARTS:
        raise ForbiddenPathError(path)
    return parts


def _open(name: str, flags: int, folder: int | None) -> int:
    try:
        return os.open(name, flags, dir_fd=folder)
    except (OSError, ValueError):
        if folder is not None and _is_link(name, folder):
            raise ForbiddenPathError(name) from None
        raise FileNotFoundError(name) from None


def _is_link(name: str, folder: int) -> bool:
    try:
        return stat.S_ISLNK(os.stat(name, dir_fd=folder, follow_symlinks=False).st_mode)
    except (OSError, ValueError):
        return False
