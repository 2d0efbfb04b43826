"""The process in which the parts that a user brings work; it ends with its parent, and alone.

It hears images over a socket and answers each by a decision or by a failure. What a part raises,
SystemExit included, is a failure; what it prints goes to standard error.
"""

import contextlib
import ctypes
import os
import signal
import socket
import struct
from pathlib import Path
from typing import NoReturn

from flightstack.companion.piloting.check import fault_of
from flightstack.companion.piloting.failure import PartFailure, PartMarker, explain
from flightstack.companion.piloting.in_process import try_pilot
from flightstack.companion.piloting.protocols import Pilot, PilotLoader
from flightstack.companion.piloting.wire import (
    DECIDED,
    FAILED,
    LOADED,
    READY,
    REFUSED,
    read_image,
    write_decision,
)
from flightstack.errors import FlightstackError, UsageError
from flightstack.mavlink.motion import MotionHistory

MAX_MESSAGE = 1 << 17
PR_SET_PDEATHSIG = 1  # Linux prctl


def serve(
    channel: socket.socket, load: PilotLoader, marker: PartMarker, motion: MotionHistory
) -> NoReturn:
    """Load, try, then answer images until the other end is closed; never returns.

    `motion` is this process's own copy, which is kept up to date as the parent tells of poses.
    """
    code = 1
    try:
        _stand_alone(channel)
        pilot = _ready_pilot(channel, load, marker)
        while pilot is not None and (data := channel.recv(MAX_MESSAGE)):
            channel.send(_answer(pilot, data, marker, motion))
        code = 0
    finally:
        os._exit(code)


def _stand_alone(channel: socket.socket) -> None:
    """Keep nothing of the parent's but standard error: no socket, no log, no terminal's Ctrl-C."""
    os.setsid()
    ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    for number in [int(entry.name) for entry in Path("/proc/self/fd").iterdir()]:
        if number > 2 and number != channel.fileno():
            with contextlib.suppress(OSError):
                os.close(number)
    with Path(os.devnull).open() as nothing:
        os.dup2(nothing.fileno(), 0)
    os.dup2(2, 1)


def _ready_pilot(channel: socket.socket, load: PilotLoader, marker: PartMarker) -> Pilot | None:
    try:
        make = load(marker)
        pilot = make()
        channel.send(LOADED)
        tried = try_pilot(pilot, marker)
        pilot = make()
    except FlightstackError as error:
        channel.send(REFUSED + bytes([error.exit_code]) + str(error).encode())
        return None
    except BaseException as error:
        reason = f"{marker.part} {explain(error)} while it was loaded or tried"
        channel.send(REFUSED + bytes([UsageError.exit_code]) + reason.encode())
        return None
    if isinstance(tried, PartFailure):
        reason = f"{tried}, when it was tried on a made-up image"
        channel.send(REFUSED + bytes([UsageError.exit_code]) + reason.encode())
        return None
    channel.send(READY + struct.pack("<d", tried))
    return pilot


def _answer(pilot: Pilot, data: bytes, marker: PartMarker, motion: MotionHistory) -> bytes:
    image, pose = read_image(data)
    if pose is not None:
        motion.note(pose)
    try:
        decision = pilot.decide(image)
        fault = fault_of(decision)
        if fault is None:
            return DECIDED + write_decision(decision)
    except BaseException as error:  # a part may raise anything, even to end the process
        fault = explain(error)
    return FAILED + f"{marker.part} {fault}".encode()
