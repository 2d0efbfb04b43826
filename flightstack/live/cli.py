"""The command line: look at a flight live, or at a log; keep it as a file, or as a page."""

import argparse
import signal
import sys
import time
from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import IO, TYPE_CHECKING

from flightstack.arguments.parser import OptionParser
from flightstack.errors import FlightstackError, UsageError
from flightstack.printable import printable

if TYPE_CHECKING:
    from flightstack.live.scene.drawing import FlightDrawing
    from flightstack.live.viewer.store import RecordingStore

PROGRAM = "flightstack.live"
DEFAULT_LINK = "udpin:127.0.0.1:14550"  # a ground station's port
DEFAULT_DETECTOR, NO_DETECTOR = "strong/b0", "none"
EXIT_INTERRUPTED = 130


def build_parser(program: str = PROGRAM) -> argparse.ArgumentParser:
    """Describe the command line."""
    parser = OptionParser(
        prog=program,
        description="Show a flight in a browser: what the camera sees, the course, commands and "
        "velocities, uncertainty, modes and texts, on one axis of time.",
    )
    add = parser.add_argument
    add("log", nargs="?", type=Path, metavar="LOG", help="show this log instead of a live flight")
    add("--connect", default=DEFAULT_LINK, metavar="STRING", help=f"default {DEFAULT_LINK}")
    add("--system", type=int, metavar="N", help="of the vehicle (default: the first)")
    add("--camera", metavar="URI", help="default: what the vehicle names; none: no images")
    add("--frames", type=Path, metavar="FOLDER", help="of a log's images; default LOG.frames")
    add("--gates", default=DEFAULT_DETECTOR, metavar="MODEL", help="by which gates are seen; none")
    add("--ground-station", action="store_true", help="send heartbeats: the autopilot's texts, too")
    add("--save", type=Path, metavar="RRD", help="keep the recording")
    add("--html", type=Path, metavar="HTML", help="keep one page that opens offline")
    add("--port", type=int, default=0, help="of the page, on this machine alone (default: any)")
    add("--seconds", type=float, metavar="S", help="end after so long")
    return parser


def main(argv: Sequence[str] | None = None, program: str = PROGRAM) -> int:
    """Show, and say where; errors are one line."""
    options = build_parser(program).parse_args(argv)
    signal.signal(signal.SIGTERM, signal.default_int_handler)  # what is to be kept is kept
    try:
        return _run(options)
    except KeyboardInterrupt:
        return EXIT_INTERRUPTED
    except FlightstackError as error:
        print(f"{program}: {printable(str(error))}", file=sys.stderr)
        return error.exit_code


def _run(options: argparse.Namespace) -> int:
    from flightstack.live.viewer.files import viewer_files  # noqa: PLC0415  --help is at once
    from flightstack.live.viewer.server import ViewerServer  # noqa: PLC0415
    from flightstack.live.viewer.store import RecordingStore  # noqa: PLC0415

    drawing, store = _drawing(options), RecordingStore()
    if options.log is not None:
        _replay(options, drawing, store)
    kept_only = options.log is not None and (options.save or options.html)
    try:
        if not kept_only:
            with ViewerServer(viewer_files(), store, options.port) as server:
                _tell(f"live view: {server.address}  (Ctrl-C ends it)")
                _show(options, drawing, store)
    finally:
        _keep(options, store)
    return 0


def _drawing(options: argparse.Namespace) -> "FlightDrawing":
    from flightstack.gate_models import load_gate_model  # noqa: PLC0415
    from flightstack.live.scene.drawing import FlightDrawing  # noqa: PLC0415

    name = options.log.name if options.log is not None else options.connect
    sees = options.gates != NO_DETECTOR
    detector = load_gate_model(options.gates).detector if sees else None
    return FlightDrawing(name, options.system, detector)


def _replay(options: argparse.Namespace, drawing: "FlightDrawing", store: "RecordingStore") -> None:
    from flightstack.live.replay import draw_log  # noqa: PLC0415
    from flightstack.logs import read  # noqa: PLC0415

    folder = options.frames or options.log.with_suffix(".frames")
    count = draw_log(drawing, read(options.log), folder)
    store.add(drawing.take())
    store.end()
    _tell(f"{options.log}: {count} images" + ("" if count else f"; {folder} holds none"))


def _show(options: argparse.Namespace, drawing: "FlightDrawing", store: "RecordingStore") -> None:
    """Serve until the end; of a live flight, keep what comes, on the disk at once."""
    from flightstack.live.link import LiveLink  # noqa: PLC0415
    from flightstack.live.session import LiveSession  # noqa: PLC0415
    from flightstack.mavlink.endpoint import parse_endpoint  # noqa: PLC0415

    ends_s = None if options.seconds is None else time.monotonic() + options.seconds
    if options.log is not None:
        while ends_s is None or time.monotonic() < ends_s:
            time.sleep(0.2)
        return
    with ExitStack() as open_files:
        file = open_files.enter_context(_opened(options.save)) if options.save else None

        def keep(piece: bytes) -> None:
            store.add(piece)
            if file is not None:
                file.write(piece)

        link = LiveLink(parse_endpoint(options.connect), beats=options.ground_station)
        try:
            LiveSession(link, drawing, options.camera, _tell).run(keep, ends_s)
        finally:
            store.end()


def _keep(options: argparse.Namespace, store: "RecordingStore") -> None:
    from flightstack.live.viewer.files import viewer_files  # noqa: PLC0415
    from flightstack.live.viewer.page import offline_page  # noqa: PLC0415

    if options.save is not None:
        if options.log is not None:
            with _opened(options.save) as file:
                file.write(store.read())
        _tell(f"wrote {options.save}")
    if options.html is not None:
        with _opened(options.html) as file:
            file.write(offline_page(viewer_files(), store.read()))
        _tell(f"wrote {options.html}")


def _opened(path: Path) -> IO[bytes]:
    try:
        return path.open("wb")
    except OSError as error:
        raise UsageError(f"{path} cannot be written: {error.strerror}") from error


def _tell(text: str) -> None:
    print(printable(text), file=sys.stderr, flush=True)
