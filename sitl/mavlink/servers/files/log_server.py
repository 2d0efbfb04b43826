"""Serve the flight logs: list them, send them piece by piece; erasing is refused."""

import os
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Protocol

from sitl.clock import SECOND_US
from sitl.mavlink.servers.files.flight_log import LogFile
from sitl.mavlink.servers.request import Outlet, Request
from sitl.mavlink.wire.dialect import Message, mavlink
from sitl.mavlink.wire.refusals import Refusal, Refusals

PIECE_BYTES = 90  # LOG_DATA
RATE_HZ = 5000  # pieces: 450 kB/s
MAX_BURST = 20  # pieces in one call, however long it was ago


class Logs(Protocol):
    """Whoever has the logs."""

    @property
    def finished(self) -> Sequence[LogFile]:
        """The logs that no longer grow, the oldest first."""


@dataclass(slots=True)
class _Transfer:
    """What is being sent on one link."""

    number: int
    descriptor: int
    offset: int
    end: int


class LogServer:
    """Answer the log messages; one transfer for each link and component at a time."""

    def __init__(self, logs: Logs, refusals: Refusals | None = None) -> None:
        self._logs = logs
        self._refusals = refusals or Refusals()
        self._transfers: dict[Outlet, _Transfer] = {}

    @property
    def is_sending(self) -> bool:
        """Whether a log is being sent."""
        return bool(self._transfers)

    def request_list(self, message: Message, request: Request) -> None:
        """Answer LOG_REQUEST_LIST: an entry for each log asked for, or one that says none."""
        logs = self._logs.finished
        last = max(0, len(logs) - 1)
        if not logs:
            request.outlet.send(mavlink.MAVLink_log_entry_message(0, 0, 0, 0, 0))
        for number in range(min(message.start, last), min(message.end, last) + 1):
            if number < len(logs):
                entry = logs[number]
                request.outlet.send(
                    mavlink.MAVLink_log_entry_message(
                        number, len(logs), last, entry.started_unix_s, entry.size
                    )
                )

    def request_data(self, message: Message, request: Request) -> None:
        """Begin to send what LOG_REQUEST_DATA asks for; silent where there is no such log."""
        logs = self._logs.finished
        if message.id >= len(logs):
            return
        self._stop(request.outlet)
        size = logs[message.id].size
        with suppress(OSError):  # somebody has taken it away
            self._transfers[request.outlet] = _Transfer(
                number=message.id,
                descriptor=os.open(logs[message.id].path, os.O_RDONLY | os.O_NOFOLLOW),
                offset=message.ofs,
                end=min(size, message.ofs + message.count),
            )

    def request_end(self, _message: Message, request: Request) -> None:
        """Stop sending: LOG_REQUEST_END."""
        self._stop(request.outlet)

    def erase(self, _message: Message, _request: Request) -> None:
        """Refuse LOG_ERASE, which has no answer."""
        self._refusals.note([Refusal.FILE_ACCESS])

    def advance(self, elapsed_us: int) -> None:
        """Send what is due of the transfers under way, `elapsed_us` after the last call."""
        count = min(MAX_BURST, max(1, elapsed_us * RATE_HZ // SECOND_US))
        for outlet, transfer in list(self._transfers.items()):
            for _ in range(count):
                if not _send_piece(outlet, transfer):
                    self._stop(outlet)
                    break

    def close(self) -> None:
        """Close all files."""
        for outlet in list(self._transfers):
            self._stop(outlet)

    def _stop(self, outlet: Outlet) -> None:
        transfer = self._transfers.pop(outlet, None)
        if transfer is not None:
            os.close(transfer.descriptor)


def _send_piece(outlet: Outlet, transfer: _Transfer) -> bool:
    """Send one piece; whether there is more. A piece that is not full says: the end."""
    wanted = max(0, min(PIECE_BYTES, transfer.end - transfer.offset))
    data = os.pread(transfer.descriptor, wanted, transfer.offset) if wanted else b""
    outlet.send(
        mavlink.MAVLink_log_data_message(
            transfer.number, transfer.offset, len(data), data.ljust(PIECE_BYTES, b"\0")
        )
    )
    transfer.offset += len(data)
    return len(data) == PIECE_BYTES and transfer.offset < transfer.end
