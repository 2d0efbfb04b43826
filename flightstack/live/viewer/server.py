"""Serve page, viewer and recording on the loopback interface, and to nobody else.

A request that names another host is refused: a page of somebody else's, whose name leads here,
reads nothing.
"""

import contextlib
import threading
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from types import TracebackType
from typing import Self

from flightstack.errors import LinkError
from flightstack.live.viewer.files import LOOPBACK, SCRIPT, WASM, ViewerFiles
from flightstack.live.viewer.page import SERVED, served_page
from flightstack.live.viewer.store import RecordingStore

RECORDING = "flight.rrd"
LOST = (BrokenPipeError, ConnectionResetError)


class ViewerServer:
    """A server of one recording; serves while it is entered."""

    def __init__(self, viewer: ViewerFiles, store: RecordingStore, port: int = 0) -> None:
        """Listen; raises LinkError where the port cannot be had."""
        pages = {
            "/": (served_page(), "text/html; charset=utf-8", None),
            f"/{SCRIPT}": (viewer.script, "text/javascript", None),
            f"/{WASM}": (viewer.wasm_gzip, "application/wasm", "gzip"),
        }
        handler = type("Handler", (_Handler,), {"pages": pages, "store": store})
        try:
            self._server = ThreadingHTTPServer((LOOPBACK, port), handler)
        except OSError as error:
            raise LinkError(
                f"port {port} for the live view: {error.strerror}; choose another by --port"
            ) from error
        self._server.daemon_threads = True
        self._thread = threading.Thread(target=self._server.serve_forever, name="page", daemon=True)

    @property
    def address(self) -> str:
        """Where the page is."""
        return f"http://{LOOPBACK}:{self._server.server_port}/"

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None
    ) -> None:
        self._server.shutdown()
        self._server.server_close()


class _Handler(BaseHTTPRequestHandler):
    """One request."""

    pages: dict[str, tuple[bytes, str, str | None]]
    store: RecordingStore

    def do_GET(self) -> None:
        """Answer with a page, or with the recording as it grows."""
        port = self.connection.getsockname()[1]
        if self.headers.get("Host") not in (f"{LOOPBACK}:{port}", f"localhost:{port}"):
            self.send_error(HTTPStatus.FORBIDDEN)
            return
        path = self.path.partition("?")[0]
        with contextlib.suppress(*LOST):  # whoever looked may have gone
            if path == f"/{RECORDING}":
                self._head("application/octet-stream")
                for piece in self.store.follow():
                    self.wfile.write(piece)
            elif path in self.pages:
                content, kind, coding = self.pages[path]
                self._head(kind, len(content), coding)
                self.wfile.write(content)
            else:
                self.send_error(HTTPStatus.NOT_FOUND)

    def _head(self, kind: str, length: int | None = None, coding: str | None = None) -> None:
        self.send_response(HTTPStatus.OK)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Security-Policy", SERVED)
        self.send_header("X-Content-Type-Options", "nosniff")
        self.send_header("Referrer-Policy", "no-referrer")
        self.send_header("Cache-Control", "no-store")
        if coding is not None:
            self.send_header("Content-Encoding", coding)
        if length is not None:
            self.send_header("Content-Length", str(length))
        self.end_headers()

    def log_message(self, format: str, *args: object) -> None:  # noqa: A002  as its base has it
        """Say nothing: standard error is for what the user is to know."""
