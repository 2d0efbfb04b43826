"""Tell a vehicle's own log by its first bytes, and read it."""

import importlib
import os
from typing import NamedTuple

from flightstack.logs.onboard.topics import OnboardRecords


class OnboardKind(NamedTuple):
    """One format: its first bytes, and the module and function that read it."""

    magic: bytes
    module: str
    function: str


KINDS = (
    OnboardKind(b"ULog\x01\x12\x35", "ulog", "read_ulog"),
    OnboardKind(b"\xa3\x95", "dataflash", "read_dataflash"),
)


def read_onboard(path: str | os.PathLike[str]) -> OnboardRecords | None:
    """Return what a vehicle's own log holds; None where the file is none, or cannot be opened.

    LogFileError where it is one and cannot be read.
    """
    name = os.fspath(path)
    try:
        with open(name, "rb") as file:  # noqa: PTH123  # a Path takes longer to import
            head = file.read(8)
    except OSError:
        return None  # who reads tlogs says why
    for kind in KINDS:
        if head.startswith(kind.magic):
            module = importlib.import_module(f"flightstack.logs.onboard.{kind.module}")
            records: OnboardRecords = getattr(module, kind.function)(name)
            return records
    return None
