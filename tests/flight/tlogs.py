"""Read telemetry logs with pymavlink, as everybody else does."""

from collections.abc import Callable
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


def seconds_until(
    messages: list[Any], name: str, meets: Callable[[Any], bool], since_s: float
) -> float:
    """Vehicle time from `since_s` to the first such message of the autopilot itself."""
    found = (m for m in of_type(messages, name) if m.get_srcComponent() == 1 and meets(m))
    return float(next(m._timestamp for m in found if m._timestamp >= since_s) - since_s)
