"""The signing key on disk: 64 hexadecimal digits, or 32 bytes as they are; empty for none yet."""

import logging
from pathlib import Path

from sitl.errors import UsageError
from sitl.process.options.file_replacement import replace_file

KEY_BYTES = 32
OWNER_ONLY = 0o600

_log = logging.getLogger(__name__)


def read_key(path: Path) -> bytes | None:
    """Read a key; None if the file is empty.

    Raises:
        UsageError: the file cannot be read, or is no key.

    """
    try:
        content = path.read_bytes()
    except OSError as error:
        raise UsageError(f"--signing-key {path}: {error.strerror}") from None
    key = content if len(content) == KEY_BYTES else _from_hex(content)
    if key == b"":
        return None
    if key is None or len(key) != KEY_BYTES or not any(key):
        raise UsageError(
            f"--signing-key {path}: must hold 64 hexadecimal digits or 32 bytes, not all zero"
        )
    return key


def write_key(path: Path, key: bytes | None) -> None:
    """Replace the file's key; if that fails, the key is good until the vehicle ends."""
    try:
        replace_file(path, "" if key is None else f"{key.hex()}\n", mode=OWNER_ONLY)
    except OSError as error:
        _log.warning("signing key %s is not kept: %s", path, error.strerror)


def _from_hex(content: bytes) -> bytes | None:
    try:
        return bytes.fromhex(content.decode("ascii"))
    except ValueError:
        return None
