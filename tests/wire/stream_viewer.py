"""Read the camera stream part by part."""

import socket
from dataclasses import dataclass
from typing import Self
from urllib.parse import urlsplit

BOUNDARY = b"--frame\r\n"


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """One image as it came."""

    time_us: int
    sequence: int
    content_type: str
    data: bytes


class StreamViewer:
    """A blocking client of a multipart stream."""

    def __init__(self, uri: str, timeout_s: float = 20.0) -> None:
        address = urlsplit(uri)
        assert address.hostname is not None
        self._socket = socket.create_connection(
            (address.hostname, address.port or 80), timeout=timeout_s
        )
        self._socket.sendall(f"GET {address.path} HTTP/1.1\r\nHost: x\r\n\r\n".encode())
        self._file = self._socket.makefile("rb")
        self.head = self._lines()
        assert self._file.readline() == BOUNDARY

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._file.close()
        self._socket.close()

    def read(self) -> Part:
        """Wait for the next part."""
        headers = dict(line.split(": ", 1) for line in self._lines())
        data = self._file.read(int(headers["Content-Length"]))
        assert self._file.readline() == b"\r\n"
        assert self._file.readline() == BOUNDARY
        seconds, microseconds = headers["X-Timestamp"].split(".")
        return Part(
            time_us=int(seconds) * 1_000_000 + int(microseconds),
            sequence=int(headers["X-Sequence"]),
            content_type=headers["Content-Type"],
            data=data,
        )

    def _lines(self) -> list[str]:
        lines = []
        while (line := self._file.readline().decode().rstrip("\r\n")) != "":
            lines.append(line)
        return lines
