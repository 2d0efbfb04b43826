"""A small RTSP server (RFC 2326): plays RTP packets to one client, inside its connection."""

import contextlib
import re
import socket
import threading
from collections.abc import Generator
from typing import Self

SDP = (
    "v=0\r\no=- 0 0 IN IP4 127.0.0.1\r\ns=camera\r\nc=IN IP4 0.0.0.0\r\nt=0 0\r\n"
    "m=video 0 RTP/AVP 96\r\na=rtpmap:96 H264/90000\r\na=control:track\r\n"
)
HEADERS = {
    "OPTIONS": "Public: OPTIONS, DESCRIBE, SETUP, PLAY, TEARDOWN\r\n",
    "DESCRIBE": f"Content-Type: application/sdp\r\nContent-Length: {len(SDP)}\r\n",
    "SETUP": "Transport: RTP/AVP/TCP;unicast;interleaved=0-1\r\nSession: 1\r\n",
}


class RtspServer:
    """Answers one client, and sends it a packet whenever the source gives one."""

    def __init__(self, packets: Generator[bytes, None, None]) -> None:
        self._packets = packets
        self._server = socket.create_server(("127.0.0.1", 0))
        self.uri = f"rtsp://127.0.0.1:{self._server.getsockname()[1]}/front"
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._server.close()
        self._thread.join(5)

    def _run(self) -> None:
        with contextlib.suppress(OSError), contextlib.closing(self._packets):
            client, _ = self._server.accept()
            with client:
                while self._answer(client) != "PLAY":
                    pass
                for packet in self._packets:
                    client.sendall(b"$\0" + len(packet).to_bytes(2, "big") + packet)

    def _answer(self, client: socket.socket) -> str:
        request = b""
        while b"\r\n\r\n" not in request:
            received = client.recv(4096)
            if not received:
                raise OSError
            request += received
        method = request.split(b" ", 1)[0].decode()
        number = re.search(rb"CSeq: *(\d+)", request)
        assert number is not None
        head = f"RTSP/1.0 200 OK\r\nCSeq: {number[1].decode()}\r\n{HEADERS.get(method, '')}\r\n"
        client.sendall((head + (SDP if method == "DESCRIBE" else "")).encode())
        return method
