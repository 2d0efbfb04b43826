"""What several commands are given: lists of names, folders, outputs; and how they are refused."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from flightstack.logs.errors import LogFileError

if TYPE_CHECKING:
    from pathlib import Path


def names_in(given: str | None) -> list[str]:
    """Return the names of a list with commas, such as --types; none where none was given."""
    return [name.strip() for name in (given or "").split(",") if name.strip()]


def check_folder(frames: "Path | None") -> None:
    """Refuse a folder of --frames that is none."""
    if frames is not None and not frames.is_dir():
        raise LogFileError(f"--frames {frames}: no such folder")


@contextmanager
def writing(output: "Path", remedy: str = "; use -o") -> Iterator[None]:
    """Turn what the system says of an output that cannot be written into one line."""
    try:
        yield
    except OSError as error:
        raise LogFileError(f"{output} cannot be written: {error.strerror}{remedy}") from error
