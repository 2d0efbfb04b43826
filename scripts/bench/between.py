"""What stands between two processes: a thread of its own, and an ear for what a vehicle says."""

import threading
from collections.abc import Iterator
from typing import Self

from pymavlink.dialects.v20 import common

from flightstack.mavlink.packets import identify, split_packets

ENDS_S = 5.0
MODE, BASE_MODE = slice(10, 14), 16  # where a HEARTBEAT of MAVLink 2 has them


class Threaded:
    """Does `_run` on a thread of its own, from entering it as a context to leaving it.

    `_run` ends soon after `_stop` is set; `_close` then lets go of what it used.
    """

    def __init__(self) -> None:
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._stop.set()
        self._thread.join(ENDS_S)
        self._close()

    def _run(self) -> None:
        raise NotImplementedError

    def _close(self) -> None:
        pass


def told_modes(datagram: bytes) -> Iterator[tuple[int, bool]]:
    """Give mode and "armed" of each HEARTBEAT of an autopilot in a datagram."""
    for packet in split_packets(datagram)[0]:
        if identify(packet)[0::2] == (common.MAVLINK_MSG_ID_HEARTBEAT, 1):
            mode = int.from_bytes(packet[MODE], "little")
            yield mode, bool(packet[BASE_MODE] & common.MAV_MODE_FLAG_SAFETY_ARMED)
