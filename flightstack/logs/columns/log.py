"""A MAVLink log as columns."""

from collections.abc import Callable, Iterable
from fnmatch import fnmatchcase
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.columns.payloads import gather
from flightstack.logs.columns.table import Table
from flightstack.logs.dialect.message_types import (
    MessageType,
    ids_by_name,
    message_id,
    message_name,
    message_type,
)
from flightstack.logs.tlog.packets import Packets, tally
from flightstack.logs.tlog.source import ByteSource, mapped
from flightstack.mavlink_numbers import AUTOPILOT_COMPONENT

if TYPE_CHECKING:
    from flightstack.logs.tlog.damage import Damage
    from flightstack.logs.tlog.losses import SourceLoss


class Log:
    """The packets of a log, and their messages by type.

    `log["ATTITUDE"]` decodes that type and no other; a type that the log does not hold is an
    empty table. `packets` and `time_us` cover all that was selected, in file order.
    """

    is_telemetry = True  # it came over a link; else it is the vehicle's own log

    def __init__(
        self,
        source: ByteSource,
        packets: Packets,
        time_us: NDArray[np.int64],
        read_whole: "Callable[[], Log] | None" = None,
    ) -> None:
        self.source = source
        self.packets = packets
        self.time_us = time_us  # since 1970; lost times mended
        self._read_whole = read_whole
        self._tables: dict[int, Table] = {}

    def __len__(self) -> int:
        return len(self.packets)

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

    @property
    def whole(self) -> "Log":
        """The log with all of its packets, whatever was selected of it."""
        return self if self._read_whole is None else self._whole_again  # no cycle of itself

    @cached_property
    def _whole_again(self) -> "Log":
        return self if self._read_whole is None else self._read_whole()

    @cached_property
    def counts(self) -> dict[str, int]:
        """How many messages of each type there are, UNKNOWN_<id> included, most first."""
        pairs = sorted(self._held.items(), key=lambda pair: (-pair[1], pair[0]))
        return {self.name_of(msgid): count for msgid, count in pairs}

    @cached_property
    def _held(self) -> dict[int, int]:
        """How many messages of each id there are."""
        return tally(self.packets.msgid)

    def name_of(self, msgid: int) -> str:
        """Return the name of the messages with this id; UNKNOWN_<id> where the dialect has none."""
        return message_name(msgid)

    def id_of(self, name: str) -> int:
        """Return the id of the messages called `name`; UnknownNameError names the nearest."""
        return message_id(name)

    @cached_property
    def losses(self) -> "tuple[SourceLoss, ...]":
        """What the sequence numbers of every sender tell about the link."""
        from flightstack.logs.columns.boot_clock import clocked_names, restart_rows  # noqa: PLC0415
        from flightstack.logs.tlog.losses import find_losses  # noqa: PLC0415  # few ask for it

        tables = (self[name] for name in clocked_names(self.counts))
        systems = set(tally(self.packets.system[self.packets.component == AUTOPILOT_COMPONENT]))
        return find_losses(self.packets, restart_rows(tables, systems))

    @cached_property
    def damage(self) -> "Damage":
        """What the whole log has lost, whatever was selected of it."""
        from flightstack.logs.tlog.damage import find_damage  # noqa: PLC0415  # few ask for it

        return find_damage(self.source, self.whole.packets, self.whole.time_us)

    def load(self, names: Iterable[str]) -> None:
        """Decode several types while reading the log once; `log[name]` is then at once."""
        types = {message_id(name) for name in names} - self._tables.keys()
        if not types:
            return
        none = np.empty(0, dtype=np.intp)
        rows = {
            msgid: np.flatnonzero(self.packets.msgid == msgid) if msgid in self._held else none
            for msgid in types
        }
        kinds = {msgid: _type_or_raw(msgid) for msgid in types}
        parts = {msgid: self.packets.take(rows[msgid]) for msgid in types}
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
        lengths = table.packets.length.tolist()
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
        ids = [] if types is None else self.matching_ids(types)
        is_every_type = types is None or len(ids) == len(self.counts)
        if is_every_type and all(given is None for given in (system, component, start_us, end_us)):
            return self
        keep = np.ones(len(self.packets), dtype=np.bool_)
        if not is_every_type:
            keep &= np.isin(self.packets.msgid, ids)
        if system is not None:
            keep &= self.packets.system == system
        if component is not None:
            keep &= self.packets.component == component
        if start_us is not None:
            keep &= self.time_us >= start_us
        if end_us is not None:
            keep &= self.time_us < end_us
        return self.rows(keep)

    def mapped(self) -> "Log":
        """Return the log with a small file mapped into memory: for programs that end soon."""
        return Log(mapped(self.source), self.packets, self.time_us, lambda: self.whole)

    def rows(self, rows: NDArray[np.bool_] | NDArray[np.intp] | slice) -> "Log":
        """Return the part of the log with these packets."""
        return Log(self.source, self.packets.take(rows), self.time_us[rows], lambda: self.whole)

    def matching_ids(self, patterns: Iterable[str]) -> list[int]:
        """Return the ids of the log's messages that match one of the names or wildcards.

        UnknownNameError where a pattern is no message of the dialect at all.
        """
        patterns = list(patterns)
        held = {name: message_id(name) for name in self.counts}
        for pattern in patterns:
            if not any(fnmatchcase(name, pattern) for name in (*held, *ids_by_name())):
                message_id(pattern)
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
