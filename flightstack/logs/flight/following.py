"""Follow a log that is being written, or a live link: events and rates as they come."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.errors import LogFileError
from flightstack.logs.flight.course import REFEREE
from flightstack.logs.flight.modes import mode_name
from flightstack.logs.flight.texts import status_texts
from flightstack.logs.flight.vehicle import ARMED, AUTOPILOT_INVALID
from flightstack.logs.tlog.damage import find_losses
from flightstack.logs.tlog.frames import Frames, join
from flightstack.logs.tlog.log import Log
from flightstack.logs.tlog.reading import read_bytes

MOST_PENDING = 1 << 16  # bytes that may wait for the rest of a frame
Facts = dict[str, Any]


class PieceReader:
    """Cuts a growing stream of bytes into logs of whole frames."""

    def __init__(self) -> None:
        self._pending = b""

    def feed(self, data: bytes) -> Log:
        """Return the frames that are now whole."""
        self._pending += data
        log = read_bytes(self._pending)
        used = int(log.frames.end[-1]) if len(log) else 0
        self._pending = self._pending[used:][-MOST_PENDING:]
        return log


@dataclass
class Watch:
    """Turns pieces of a log into events; keeps what it needs from piece to piece."""

    modes: dict[tuple[int, int], str] = field(default_factory=dict)
    armed: dict[tuple[int, int], bool] = field(default_factory=dict)
    since: list[Frames] = field(default_factory=list)  # frames since the last rates

    def events(self, log: Log) -> Iterator[Facts]:
        """Yield mode changes, arming, texts and gates of this piece, in order of time."""
        found = [*self._heartbeats(log), *self._texts(log), *self._gates(log)]
        self.since.append(log.frames)
        yield from sorted(found, key=lambda event: int(event["time_us"]))

    def _heartbeats(self, log: Log) -> Iterator[Facts]:
        beats = log["HEARTBEAT"]
        names = ("autopilot", "type", "base_mode", "custom_mode")
        columns = [beats[name].tolist() for name in names]
        sources = zip(beats.system.tolist(), beats.component.tolist(), strict=True)
        for time_us, source, autopilot, kind, base, custom in zip(
            beats.time_us.tolist(), sources, *columns, strict=True
        ):
            if autopilot == AUTOPILOT_INVALID:
                continue
            mode, armed = mode_name(autopilot, kind, base, custom), bool(base & ARMED)
            event = {"time_us": time_us, "source": f"{source[0]}/{source[1]}"}
            if self.modes.get(source) != mode:
                yield {**event, "event": "mode", "text": mode}
            if self.armed.get(source, False) != armed:
                yield {**event, "event": "armed" if armed else "disarmed", "text": ""}
            self.modes[source], self.armed[source] = mode, armed

    def _texts(self, log: Log) -> Iterator[Facts]:
        for text in status_texts(log):
            source = f"{text.system}/{text.component}"
            about = {"event": "text", "level": text.level, "text": text.text}
            yield {"time_us": text.time_us, "source": source, **about}

    def _gates(self, log: Log) -> Iterator[Facts]:
        reached = log["MISSION_ITEM_REACHED"]
        rows = zip(reached.time_us.tolist(), reached.component.tolist(), reached["seq"].tolist(),
                   reached.system.tolist(), strict=True)  # fmt: skip
        for time_us, component, seq, system in rows:
            what = "gate" if component == REFEREE else "item"
            about = {"event": what, "text": f"{what} {seq} reached"}
            yield {"time_us": time_us, "source": f"{system}/{component}", **about}

    def rates(self, seconds: float) -> Facts:
        """Return messages a second and loss by source since the last call."""
        frames = join(self.since)
        self.since = []
        sources = {
            f"{loss.system}/{loss.component}": {
                "rate_hz": round(loss.received / seconds, 1),
                "loss_percent": round(100 * loss.fraction, 2),
            }
            for loss in find_losses(frames)
        }
        return {"event": "rates", "rate_hz": round(len(frames) / seconds, 1), "sources": sources}


class GrowingFile:
    """Reads what is appended to a file; starts again when it was cut."""

    def __init__(self, path: Path, *, from_start: bool) -> None:
        self._path = path
        try:
            size = path.stat().st_size
        except OSError as error:
            raise LogFileError(f"{path} cannot be followed: {error.strerror}") from error
        self._position = 0 if from_start else size

    def __call__(self) -> bytes:
        """Return the bytes that came since the last call."""
        try:
            size = self._path.stat().st_size
            if size < self._position:
                self._position = 0
            with self._path.open("rb") as file:
                file.seek(self._position)
                data = file.read(1 << 22)
        except OSError as error:
            raise LogFileError(f"{self._path} cannot be followed: {error.strerror}") from error
        self._position += len(data)
        return data


def connection_string(text: str) -> str:
    """Return a connection as pymavlink writes it: a bare port, udpin:H:P and udpin://H:P."""
    if text.isdigit():
        return f"udpin:0.0.0.0:{text}"
    return text.replace("://", ":", 1)


def open_link(text: str) -> Callable[[], bytes]:
    """Return a reader of a live link; it only listens, it sends nothing."""
    from pymavlink import mavutil  # noqa: PLC0415

    try:
        link = mavutil.mavlink_connection(connection_string(text))
    except (OSError, ValueError, IndexError) as error:
        raise LogFileError(f"{text} cannot be opened: {error}; try udpin:0.0.0.0:14550") from error

    def receive() -> bytes:
        data = link.recv(4096)
        return data if isinstance(data, bytes) else b""

    return receive


def at_times(log: Log, now_us: int) -> Log:
    """Return a live piece, whose frames carry no times, as received now."""
    times: NDArray[np.int64] = np.full(len(log), now_us, dtype=np.int64)
    return Log(log.source, log.frames, times)
