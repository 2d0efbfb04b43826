"""The viewer's script and WASM: taken once out of rerun's own binary, and kept.

The binary serves them to a browser, together with a page that calls others' servers. So it is
started on a free port of the loopback interface, asked for these two files alone, and ended.
"""

import gzip
import http.client
import os
import socket
import subprocess
import time
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

from flightstack.errors import UsageError
from flightstack.files import write_whole
from flightstack.libraries import require

EXTRA, LOOPBACK = "live", "127.0.0.1"
SCRIPT, WASM = "re_viewer.js", "re_viewer_bg.wasm"
START_S, PAUSE_S = 20.0, 0.05
QUICK = 6  # of gzip's levels: 13.8 of 43 MB


class ViewerFiles(NamedTuple):
    """What the page loads."""

    script: bytes
    wasm_gzip: bytes


def viewer_files(folder: Path | None = None) -> ViewerFiles:
    """Return the files of the rerun that is installed; raises UsageError where there is none."""
    require(EXTRA, "rerun")
    kept = folder or cache_folder() / f"rerun-{version('rerun-sdk')}"
    script, wasm = kept / SCRIPT, kept / f"{WASM}.gz"
    if not (script.is_file() and wasm.is_file()):
        try:
            kept.mkdir(parents=True, exist_ok=True)
            taken = _taken()
            write_whole(script, taken[SCRIPT])
            write_whole(wasm, gzip.compress(taken[WASM], QUICK, mtime=0))
        except OSError as error:
            raise UsageError(f"the viewer's files cannot be kept in {kept}: {error}") from error
    return ViewerFiles(script.read_bytes(), wasm.read_bytes())


def cache_folder() -> Path:
    """Return where what can be made again is kept."""
    root = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
    return Path(root) / "flightstack"


def _binary() -> Path:
    found = find_spec("rerun_cli")
    place = next(iter(found.submodule_search_locations or ()), "") if found else ""
    binary = Path(place) / "rerun"
    if not binary.is_file():
        raise UsageError(f"rerun's own program is missing: {binary}; install rerun-sdk again")
    return binary


def _taken() -> dict[str, bytes]:
    """Ask the binary itself, not the script around it, which would leave it alive."""
    page, data = _free_port(), _free_port()
    command = [str(_binary()), "--serve-web", "--bind", LOOPBACK, "--port", str(data)]
    command += ["--web-viewer-port", str(page)]
    null = subprocess.DEVNULL
    server = subprocess.Popen(command, stdin=null, stdout=null, stderr=null)  # noqa: S603  rerun's
    try:
        return {name: _asked(page, name) for name in (SCRIPT, WASM)}
    finally:
        server.kill()
        server.wait()


def _asked(port: int, name: str) -> bytes:
    ends_s = time.monotonic() + START_S
    while True:
        connection = http.client.HTTPConnection(LOOPBACK, port, timeout=START_S)
        try:
            connection.request("GET", f"/{name}")
            answer = connection.getresponse()
            if answer.status != http.client.OK:
                raise UsageError(f"rerun has no {name}: install the rerun-sdk of constraints.txt")
            return answer.read()
        except ConnectionRefusedError:
            if time.monotonic() > ends_s:
                raise
            time.sleep(PAUSE_S)
        finally:
            connection.close()


def _free_port() -> int:
    with socket.socket() as free:
        free.bind((LOOPBACK, 0))
        return int(free.getsockname()[1])
