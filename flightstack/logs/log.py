"""A MAVLink log as columns."""

from collections.abc import Iterable, Iterator
from fnmatch import fnmatchcase
from functools import cached_property
from os import PathLike
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flightstack.logs import clock, damage
from flightstack.logs.boot_clock import times_since_boot_us
from flightstack.logs.damage import Damage, SourceLoss
from flightstack.logs.dialect import (
    MessageType,
    ids_by_name,
    message_id,
    message_name,
    message_type,
)
from flightstack.logs.errors import LogFileError, UnknownNameError
from flightstack.logs.frames import IS_UNKNOWN, NO_TIME, Frames, join
from flightstack.logs.payloads import gather
from flightstack.logs.scanner import scan
from flightstack.logs.source import WINDOW_BYTES, MemorySource, Source, open_source
from flightstack.logs.table import Table
from flightstack.logs.unknown import doubtful


class Log:
    """The frames of a log, and their messages by type.

    `log["ATTITUDE"]` decodes that type and no other; a type that the log does not hold is an
    empty table. `frames` and `time_us` cover all that was selected, in file order.
    """

    def __init__(
        self,
        source: Source,
        frames: Frames,
        time_us: NDArray[np.int64],
        whole: "Log | None" = None,
    ) -> None:
        self.source = source
        self.frames = frames
        self.time_us = time_us  # since 1970; lost times mended
        self._whole = whole or self
        self._tables: dict[int, Table] = {}

    def __len__(self) -> int:
        return len(self.frames)

    def __contains__(self, name: object) -> bool:
        return name in self.counts

    def __getitem__(self, name: str) -> Table:
        """Return all messages called `name`; UnknownNameError where the dialect has none."""
        msgid = message_id(name)
        self.load([name])
        return self._tables[msgid]

    @property
    def name(self) -> str:
        """What the log is called in messages: its path."""
        return self.source.name

    @cached_property
    def counts(self) -> dict[str, int]:
        """How many messages of each type there are, UNKNOWN_<id> included, most first."""
        ids, counts = np.unique(self.frames.msgid, return_counts=True)
        pairs = sorted(zip(counts.tolist(), ids.tolist(), strict=True), key=lambda p: (-p[0], p[1]))
        return {message_name(msgid): count for count, msgid in pairs}

    @cached_property
    def losses(self) -> tuple[SourceLoss, ...]:
        """What the sequence numbers of every sender tell about the link."""
        return damage.find_losses(self.frames)

    @cached_property
    def damage(self) -> Damage:
        """What the whole log has lost, whatever was selected of it."""
        whole = self._whole
        regions, has_times = damage.find_regions(whole.source, whole.frames, whole.time_us)
        _, mended = clock.mend(whole.frames.time_us)
        jumps = tuple(clock.jumps(whole.time_us))
        backwards = any(jump.jump_us < 0 for jump in jumps)
        return Damage(
            regions=tuple(regions),
            has_times=has_times,
            mended_times=mended if has_times else 0,
            jumps=jumps,
            duplicates=damage.count_duplicates(whole.frames, whole.time_us) if backwards else 0,
        )

    def load(self, names: Iterable[str]) -> None:
        """Decode several types while reading the log once; `log[name]` is then at once."""
        types = {message_id(name) for name in names} - self._tables.keys()
        rows = {msgid: np.flatnonzero(self.frames.msgid == msgid) for msgid in types}
        kinds = {msgid: _type_or_raw(msgid) for msgid in types}
        parts = {msgid: self.frames.take(rows[msgid]) for msgid in types}
        wanted = {m: (parts[m], kinds[m].size) for m in types if len(parts[m])}
        payloads = gather(self.source, wanted)
        for msgid in types:
            kind = kinds[msgid]
            raw = payloads.get(msgid, np.empty((0, kind.size), dtype=np.uint8))
            data = raw.reshape(-1).view(kind.dtype)
            times = self.time_us[rows[msgid]]
            self._tables[msgid] = Table(kind, parts[msgid], times, rows[msgid], data)

    def payloads(self, name: str) -> list[bytes]:
        """Return the payloads of a message as they were on the wire: for unknown messages."""
        table = self[name]
        raw = table.data.tobytes()
        size = table.type.size
        lengths = table.frames.length.tolist()
        return [raw[i * size : i * size + length] for i, length in enumerate(lengths)]

    def select(
        self,
        *,
        types: Iterable[str] | None = None,
        system: int | None = None,
        component: int | None = None,
        start_us: int | None = None,
        end_us: int | None = None,
    ) -> "Log":
        """Return the part of the log that passes all filters; nothing is decoded for it.

        `types` may hold wildcards; times are microseconds since 1970, start inclusive, end not.
        """
        keep = np.ones(len(self.frames), dtype=np.bool_)
        if types is not None:
            keep &= np.isin(self.frames.msgid, self.matching_ids(types))
        if system is not None:
            keep &= self.frames.system == system
        if component is not None:
            keep &= self.frames.component == component
        if start_us is not None:
            keep &= self.time_us >= start_us
        if end_us is not None:
            keep &= self.time_us < end_us
        return self.rows(keep)

    def rows(self, rows: NDArray[np.bool_] | NDArray[np.intp] | slice) -> "Log":
        """Return the part of the log with these frames."""
        return Log(self.source, self.frames.take(rows), self.time_us[rows], self._whole)

    def matching_ids(self, patterns: Iterable[str]) -> list[int]:
        """Return the ids of the log's messages that match one of the names or wildcards.

        UnknownNameError where a pattern is no message of the dialect at all.
        """
        patterns = list(patterns)
        for pattern in patterns:
            if not any(fnmatchcase(name, pattern) for name in ids_by_name()):
                message_id(pattern)
        held = {name: message_id(name) for name in self._whole.counts}
        return [held[n] for n in held if any(fnmatchcase(n, pattern) for pattern in patterns)]


def _type_or_raw(msgid: int) -> MessageType:
    """Return the message type; for an unknown id one with a single field of raw bytes."""
    known = message_type(msgid)
    if known is not None:
        return known
    return MessageType(
        id=msgid,
        name=message_name(msgid),
        crc_extra=0,
        size=255,
        dtype=np.dtype([("payload", "V255")]),
        fields=(),
    )


def from_frames(source: Source, frames: Frames) -> Log:
    """Return a log of frames that were found in `source`."""
    if (frames.flags & IS_UNKNOWN).any():
        frames = frames.take(~doubtful(frames))
    if len(frames) and bool((frames.time_us == NO_TIME).all()):
        return Log(source, frames, times_since_boot_us(source, frames))
    times, _ = clock.mend(frames.time_us)
    return Log(source, frames, times)


def read(
    path: str | PathLike[str],
    *,
    types: Iterable[str] | None = None,
    system: int | None = None,
    component: int | None = None,
    start_us: int | None = None,
    end_us: int | None = None,
    window_bytes: int = WINDOW_BYTES,
) -> Log:
    """Read a log: find every frame, check every checksum, decode nothing yet.

    The file is read in windows, so that memory is bounded by the index (26 bytes a frame) and by
    what is asked for. Raises LogFileError, one line that says what to do, for what is no log.
    """
    source = open_source(Path(path))
    log = from_frames(source, join(list(scan(source, window_bytes))))
    if not len(log):
        raise LogFileError(f"{path} holds no MAVLink frame: it is no tlog, or damaged throughout")
    filters = (types, system, component, start_us, end_us)
    if all(given is None for given in filters):
        return log
    return log.select(
        types=types, system=system, component=component, start_us=start_us, end_us=end_us
    )


def read_bytes(data: bytes | NDArray[np.uint8], name: str = "memory") -> Log:
    """Read a log from memory; one that holds no frame is an empty log."""
    source = MemorySource(np.frombuffer(data, dtype=np.uint8), name)
    return from_frames(source, join(list(scan(source))))


def read_windows(
    path: str | PathLike[str],
    *,
    types: Iterable[str] | None = None,
    window_bytes: int = WINDOW_BYTES,
) -> Iterator[Log]:
    """Yield the log in pieces, one a window: memory stays bounded whatever the log's size."""
    source = open_source(Path(path))
    patterns = None if types is None else list(types)
    for frames in scan(source, window_bytes):
        if len(frames):
            piece = from_frames(source, frames)
            yield piece if patterns is None else piece.select(types=patterns)


__all__ = ["Log", "Table", "UnknownNameError", "read", "read_bytes", "read_windows"]
