"""Replace a small file as a whole, so that whoever reads it gets the old one or the new one."""

import contextlib
import os
from pathlib import Path

NEW_FILE_MODE = 0o666  # less the umask


def replace_file(path: Path, text: str, *, mode: int | None = None) -> None:
    """Write beside the file, then put that in its place.

    Without a mode the file keeps the one that it has. Raises OSError; the old file is still there.
    """
    draft = path.with_name(f"{path.name}.new")
    try:
        draft.unlink(missing_ok=True)
        flags = os.O_WRONLY | os.O_CREAT | os.O_EXCL
        descriptor = os.open(draft, flags, NEW_FILE_MODE if mode is None else mode)
        with os.fdopen(descriptor, "w") as file:
            file.write(text)
        if mode is None and path.exists():
            draft.chmod(path.stat().st_mode)
        draft.replace(path)
    except OSError:
        with contextlib.suppress(OSError):
            draft.unlink(missing_ok=True)
        raise
