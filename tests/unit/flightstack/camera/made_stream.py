"""A camera stream on a real socket, part by part as the test wants it."""

import contextlib
import socket
import threading

import cv2
import numpy as np
from numpy.typing import NDArray

GREETING = (
    b"HTTP/1.1 200 OK\r\nContent-Type: multipart/x-mixed-replace; boundary=b\r\n"
    b"Connection: close\r\n\r\n"
)


def picture(red: int, green: int, blue: int) -> NDArray[np.uint8]:
    return np.full((64, 64, 3), (red, green, blue), np.uint8)


def part(rgb: NDArray[np.uint8], *, suffix: str = ".png", **headers: str) -> bytes:
    content = cv2.imencode(suffix, cv2.cvtColor(rgb, cv2.COLOR_RGB2BGR))[1].tobytes()
    lines = [f"{name.replace('_', '-')}: {value}" for name, value in headers.items()]
    lines += ["Content-Type: image/png", f"Content-Length: {len(content)}"]
    return ("--b\r\n" + "\r\n".join(lines) + "\r\n\r\n").encode() + content + b"\r\n"


class MadeStream:
    """Serves each connection the same bytes, and holds it open unless told to end it."""

    def __init__(self, *chunks: bytes, greeting: bytes = GREETING, ends: bool = False) -> None:
        self.requests: list[bytes] = []
        self._chunks = chunks
        self._greeting = greeting
        self._ends = ends
        self._open: list[socket.socket] = []
        self._server = socket.create_server(("127.0.0.1", 0))
        self.uri = f"http://127.0.0.1:{self._server.getsockname()[1]}/stream"
        self._thread = threading.Thread(target=self._serve, daemon=True)

    def __enter__(self) -> "MadeStream":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._server.shutdown(socket.SHUT_RDWR)
        self._server.close()
        self._thread.join(5)
        for client in self._open:
            client.close()

    def _serve(self) -> None:
        while True:
            try:
                client, _ = self._server.accept()
            except OSError:
                return
            self._open.append(client)
            with contextlib.suppress(OSError):  # whoever has heard enough may leave
                self._answer(client)

    def _answer(self, client: socket.socket) -> None:
        self.requests.append(client.recv(4096))
        client.sendall(self._greeting)
        for chunk in self._chunks:
            client.sendall(chunk)
        if self._ends:
            client.shutdown(socket.SHUT_RDWR)
