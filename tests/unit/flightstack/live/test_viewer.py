"""The viewer's server and pages: on this machine alone, and nothing from anywhere else."""

import base64
import gzip
import http.client
import re
import subprocess
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from flightstack.errors import LinkError
from flightstack.live.viewer.files import ViewerFiles, viewer_files
from flightstack.live.viewer.page import OFFLINE, SERVED, offline_page, served_page
from flightstack.live.viewer.server import ViewerServer
from flightstack.live.viewer.store import RecordingStore

VIEWER = ViewerFiles(b"let wasm_bindgen = '</script>';", gzip.compress(b"wasm"))


@pytest.fixture
def store() -> RecordingStore:
    return RecordingStore()


@pytest.fixture
def port(store: RecordingStore) -> Iterator[int]:
    with ViewerServer(VIEWER, store) as server:
        yield int(server.address.rstrip("/").rpartition(":")[2])
        store.end()


def asked(port: int, path: str, **headers: str) -> tuple[http.client.HTTPResponse, bytes]:
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=5.0)
    connection.request("GET", path, headers=headers)
    answer = connection.getresponse()
    content = answer.read()
    connection.close()
    return answer, content


def test_page_script_and_wasm_come_from_us_under_a_policy(port: int) -> None:
    for path, content in (("/", served_page()), ("/re_viewer.js", VIEWER.script)):
        answer, got = asked(port, path)
        assert (answer.status, got) == (200, content)
        assert answer.getheader("Content-Security-Policy") == SERVED
    answer, got = asked(port, "/re_viewer_bg.wasm")
    assert (answer.getheader("Content-Encoding"), gzip.decompress(got)) == ("gzip", b"wasm")


@pytest.mark.parametrize("host", ["example.com", "127.0.0.1", "evil.test:80"])
def test_a_name_of_somebody_else_is_refused(port: int, host: str) -> None:
    assert asked(port, "/flight.rrd", Host=host)[0].status == 403


def test_a_path_that_is_none_is_no_file(port: int) -> None:
    assert asked(port, "/../../etc/passwd")[0].status == 404


def test_a_recording_is_sent_from_its_start_while_it_grows(
    port: int, store: RecordingStore
) -> None:
    store.add(b"first ")
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=5.0)
    connection.request("GET", "/flight.rrd")
    answer = connection.getresponse()
    assert answer.read(6) == b"first "
    store.add(b"second")
    assert answer.read(6) == b"second"
    store.end()
    assert answer.read() == b""
    connection.close()


def test_the_server_listens_on_the_loopback_alone(port: int) -> None:
    with pytest.raises(LinkError, match="--port"):
        ViewerServer(VIEWER, RecordingStore(), port)
    lines = [line.split() for line in Path("/proc/net/tcp").read_text().splitlines()]
    bound = {line[1] for line in lines[1:] if line[3] == "0A"}
    assert f"0100007F:{port:04X}" in bound
    assert f"00000000:{port:04X}" not in bound


def test_a_reader_of_a_store_ends_with_it(store: RecordingStore) -> None:
    got: list[bytes] = []
    reader = threading.Thread(target=lambda: got.extend(store.follow()))
    reader.start()
    store.add(b"a")
    store.add(b"")
    store.add(b"b")
    store.end()
    reader.join(5.0)
    assert (b"".join(got), store.read()) == (b"ab", b"ab")


def test_the_offline_page_holds_everything_and_may_call_nobody() -> None:
    page = offline_page(VIEWER, b"recording").decode()
    assert OFFLINE in page
    assert "connect-src 'none'" in page
    assert not re.search(r"https?://", page)
    assert page.count("</script>") == page.count("<script")  # the viewer's own is written out
    for name, content in (("wasm", b"wasm"), ("recording", b"recording")):
        found = re.search(rf'id="{name}">([^<]*)<', page)
        assert found
        assert gzip.decompress(base64.b64decode(found[1])) == content
    assert page.index('id="recording"') < page.index("async function start")


def test_the_viewer_s_files_are_taken_once_and_leave_no_process(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("rerun")
    started: list[subprocess.Popen[bytes]] = []

    class Noted(subprocess.Popen[bytes]):
        def __init__(self, *arguments: Any, **options: Any) -> None:
            super().__init__(*arguments, **options)
            started.append(self)

    monkeypatch.setattr(subprocess, "Popen", Noted)
    taken = viewer_files(tmp_path)
    assert b"WebHandle" in taken.script
    assert gzip.decompress(taken.wasm_gzip).startswith(b"\0asm")
    assert viewer_files(tmp_path) == taken
    assert [process.poll() is not None for process in started] == [True]
