"""Read telemetry logs with pymavlink, as everybody else does."""

from pathlib import Path
from typing import Any

from pymavlink import mavutil


def read(path: Path) -> list[Any]:
    """All messages of a log, in order; each has `_timestamp` (s) and its source."""
    log = mavutil.mavlink_connection(str(path), dialect="common")
    messages = []
    while (message := log.recv_msg()) is not None:
        messages.append(message)
    log.close()
    return messages


def of_type(messages: list[Any], name: str) -> list[Any]:
    return [message for message in messages if message.get_type() == name]
