"""A pilot in a process of its own: it may raise, hang, leak or die, and the flight goes on."""

import contextlib
import os
import signal
import socket
import struct
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Self

from flightstack.companion.piloting.failure import PartFailure, PartMarker
from flightstack.companion.piloting.protocols import Patience, PilotLoader
from flightstack.companion.piloting.wire import (
    DECIDED,
    LOADED,
    READY,
    read_decision,
    write_image,
)
from flightstack.companion.piloting.worker import MAX_MESSAGE, serve
from flightstack.companion.waiting import wait_for_any
from flightstack.errors import FlightstackError, ModelError, UsageError
from flightstack.mavlink.motion import MotionHistory
from flightstack.perception.preprocessing import fit_image
from flightstack.records import Decision, Image

SILENT_S = 8.0  # wall time; a vehicle in lockstep waits for 10 s
LOADS_S, TRIES_S = 300.0, 30.0  # wall time
SLICE_S = 0.1  # between two looks at how the worker does
ENDS_S = 0.05  # after its socket has closed
MEMORY_EVERY = 20  # images
PAGE_BYTES = os.sysconf("SC_PAGE_SIZE")
GB = 1e9
REFUSALS: dict[int, type[FlightstackError]] = {ModelError.exit_code: ModelError}


class WorkerPilot:
    """Asks the worker for each image; of two images at once, the later one waits."""

    def __init__(
        self,
        process_id: int,
        channel: socket.socket,
        marker: PartMarker,
        motion: MotionHistory,
        *,
        max_memory_bytes: float,
        wall_s: Callable[[], float],
    ) -> None:
        self.failure: PartFailure | None = None
        self.image_s = 0.0  # wall time of one decision, when it was tried
        self._process_id: int | None = process_id
        self._channel, self._marker, self._wall_s = channel, marker, wall_s
        self._motion = motion
        self._max_memory_bytes = max_memory_bytes
        self._asked_s: float | None = None  # an answer is awaited since then
        self._asked = 0

    @classmethod
    def start(
        cls,
        load: PilotLoader,
        motion: MotionHistory | None = None,
        *,
        max_memory_bytes: float,
        wall_s: Callable[[], float] = time.monotonic,
    ) -> Self:
        """Fork the worker and wait until it is ready; raises UsageError or ModelError if not.

        Whatever holds `motion` in `load` finds there, in its own process, what telemetry tells.
        """
        if sys.platform != "linux":
            raise UsageError("parts of your own fly on Linux alone, which can watch their process")
        motion = MotionHistory() if motion is None else motion
        ours, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        marker = PartMarker()
        sys.stdout.flush()
        process_id = os.fork()
        if process_id == 0:
            serve(theirs, load, marker, motion)
        theirs.close()
        ours.settimeout(0.0)
        pilot = cls(
            process_id, ours, marker, motion, max_memory_bytes=max_memory_bytes, wall_s=wall_s
        )
        try:
            pilot._await_ready()
        except BaseException:
            pilot.close()
            raise
        return pilot

    def fileno(self) -> int:
        """Return what a selector waits on."""
        return self._channel.fileno()

    @property
    def part(self) -> str:
        """Which part is at work."""
        return self._marker.part

    def check(self) -> PartFailure | None:
        """Say why it will never decide again, where that can be seen without an image."""
        if self.failure is None and self._asked_s is None and wait_for_any(0, self._channel):
            self._fail_for_good(self._end())
        return self.failure

    def decide(self, image: Image, patience: Patience) -> Decision | PartFailure | None:
        """Decide on the velocities that answer this image; None where the flight has gone on."""
        answer: Decision | PartFailure | None = None
        if self._asked_s is not None:  # an earlier image is being thought about
            answer = self._await(patience)
        if self.failure is None and self._asked_s is None:
            self._ask(image)
            answer = self._await(patience) or answer
        return self.failure or answer

    def close(self) -> None:
        """End the worker, and whatever it has started."""
        if self._process_id is not None:
            for end in (os.killpg, os.kill):
                with contextlib.suppress(ProcessLookupError):
                    end(self._process_id, signal.SIGKILL)
            with contextlib.suppress(ChildProcessError):
                os.waitpid(self._process_id, 0)
            self._process_id = None
        self._channel.close()

    def _ask(self, image: Image) -> None:
        fitted = replace(image, rgb=fit_image(image.rgb))
        try:
            self._channel.send(write_image(fitted, self._motion.at(image.stamp_us)))
        except OSError:
            self._fail_for_good(self._end())
            return
        self._asked_s = self._wall_s()
        self._asked += 1
        if self._asked % MEMORY_EVERY == 0:
            self._judge_memory()

    def _await(self, patience: Patience) -> Decision | PartFailure | None:
        while self.failure is None:
            if patience.wait(self):
                return self._read()
            self._judge()
            if patience.over:
                return None
        return self.failure

    def _read(self) -> Decision | PartFailure:
        data = self._receive()
        if not data:
            return self._fail_for_good(self._end())
        self._asked_s = None
        if data[:1] == DECIDED:
            return read_decision(data[1:])
        part, _, reason = data[1:].decode(errors="replace").partition(" ")
        return PartFailure(part=part, reason=reason)

    def _receive(self) -> bytes:
        try:
            return self._channel.recv(MAX_MESSAGE)
        except OSError:
            return b""

    def _judge(self) -> None:
        """Give up a worker that has died, that is silent for too long, or that takes too much."""
        if self._process_id is None:
            return
        if self._has_ended():
            self._fail_for_good(self._end())
        elif self._asked_s is not None and self._wall_s() - self._asked_s > SILENT_S:
            self._fail_for_good(f"has not answered for {SILENT_S:g} s")
        else:
            self._judge_memory()

    def _judge_memory(self) -> None:
        taken = memory_bytes(self._process_id)
        if taken > self._max_memory_bytes:
            limit = self._max_memory_bytes / GB
            self._fail_for_good(
                f"takes {taken / GB:.1f} GB of memory, above {limit:g} GB; see --part-memory"
            )

    def _fail_for_good(self, reason: str) -> PartFailure:
        if self.failure is None:
            self.failure = PartFailure(part=self._marker.part, reason=reason)
            self.close()
        return self.failure

    def _has_ended(self) -> bool:
        if self._process_id is None:
            return True
        flags = os.WEXITED | os.WNOHANG | os.WNOWAIT
        return os.waitid(os.P_PID, self._process_id, flags) is not None

    def _end(self) -> str:
        """Say how the worker has ended, or is about to."""
        if self._process_id is None:
            return "has ended"
        with contextlib.closing(_Process(self._process_id)) as process:
            wait_for_any(ENDS_S, process)
        ended = os.waitid(os.P_PID, self._process_id, os.WEXITED | os.WNOWAIT | os.WNOHANG)
        if ended is None:
            return "has closed its end"
        if ended.si_code == os.CLD_EXITED:
            return f"has ended its process with exit code {ended.si_status}"
        return f"has died by {signal.Signals(ended.si_status).name}"

    def _await_ready(self) -> None:
        self._await_message(LOADED, LOADS_S, "to be loaded")
        data = self._await_message(READY, TRIES_S, "for a made-up image")
        (self.image_s,) = struct.unpack("<d", data[1:])

    def _await_message(self, kind: bytes, limit_s: float, purpose: str) -> bytes:
        deadline_s = self._wall_s() + limit_s
        while not wait_for_any(SLICE_S, self._channel):
            self._judge()
            if self.failure is not None:
                raise UsageError(f"{self.failure}")
            if self._wall_s() > deadline_s:
                raise UsageError(f"{self._marker.part} takes more than {limit_s:g} s {purpose}")
        data = self._receive()
        if data[:1] == kind:
            return data
        if not data:
            raise UsageError(f"{self._marker.part} {self._end()} while it was loaded or tried")
        raise REFUSALS.get(data[1], UsageError)(data[2:].decode(errors="replace"))


class _Process:
    """A process that a selector can wait on: it can be read when it has ended."""

    def __init__(self, process_id: int) -> None:
        self._descriptor = _open_process(process_id)

    def fileno(self) -> int:
        return self._descriptor

    def close(self) -> None:
        os.close(self._descriptor)


def _open_process(process_id: int) -> int:
    if sys.platform != "linux":
        raise NotImplementedError
    return os.pidfd_open(process_id)


def memory_bytes(process_id: int | None) -> int:
    """Return the memory that a process holds, 0 where there is none."""
    try:
        return int(Path(f"/proc/{process_id}/statm").read_text().split()[1]) * PAGE_BYTES
    except (OSError, IndexError, ValueError):
        return 0
