"""A viewer that only looks: the setpoints of a flight in lockstep are the same with it."""

import contextlib
import select
import socket
import time
from pathlib import Path

import pytest

from flightstack.launch.instances import free_instance
from flightstack.logs import read
from tests.flight.processes import FAST, process

pytestmark = pytest.mark.flight
FLIGHT_S = 3.0
LIMIT_S = 60.0
DRAWN = (b"/camera/image", b"/world/gates", b"/world/seen")


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        return int(free.getsockname()[1])


def wait_for(file: Path, content: bytes) -> None:
    """Look again and again until a file that another process writes holds something."""
    ends_s = time.monotonic() + LIMIT_S
    while not file.is_file() or content not in file.read_bytes():
        assert time.monotonic() < ends_s, f"{file} never held {content!r}"
        select.select([], [], [], 0.05)


def fly(folder: Path, *, watched: bool) -> list[bytes]:
    """Fly for some seconds; the payloads of all setpoints."""
    folder.mkdir()
    ground, api = (free_port(), free_port()), (free_port(), free_port())
    log = folder / "companion.tlog"
    vehicle = ("--lockstep", *FAST, "--camera-port=0", "--track-seed=7")
    links = (f"--gcs-link={ground[0]}:{ground[1]}", f"--api-link={api[0]}:{api[1]}")
    live = (f"--connect=udpin:127.0.0.1:{ground[1]}", f"--save={folder / 'flight.rrd'}")
    with contextlib.ExitStack() as stack:
        begin = stack.enter_context
        begin(free_instance())
        if watched:
            begin(process("flightstack.live", *live, log=folder / "live.txt"))
            wait_for(folder / "live.txt", b"live view: http://127.0.0.1:")
        begin(process("sitl", *vehicle, *links, log=folder / "vehicle.txt"))
        companion = (f"--connect=udpin:127.0.0.1:{api[1]}", f"--log={log}")
        options = (*companion, f"--duration={FLIGHT_S}", "--no-landing")
        begin(process("flightstack.companion", *options, log=folder / "companion.txt")).wait(
            LIMIT_S
        )
        for drawn in DRAWN if watched else ():
            wait_for(folder / "flight.rrd", drawn)
    return read(log).payloads("SET_POSITION_TARGET_LOCAL_NED")


def test_setpoints_are_the_same_to_the_last_bit_with_and_without_a_viewer(tmp_path: Path) -> None:
    pytest.importorskip("rerun")
    alone = fly(tmp_path / "alone", watched=False)
    watched = fly(tmp_path / "watched", watched=True)
    assert len(alone) > 20 * FLIGHT_S
    assert watched == alone
    drawn = (tmp_path / "watched" / "flight.rrd").read_bytes()
    missing = [
        path for path in (b"/camera/image", b"/world/gates", b"/world/seen") if path not in drawn
    ]
    assert missing == []
