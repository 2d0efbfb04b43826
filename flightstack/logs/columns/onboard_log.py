"""A vehicle's own log with the face of a tlog: its topics, and the MAVLink messages made of them.

`log["vehicle_attitude"]` is a topic as it was logged; `log["ATTITUDE"]` is the MAVLink message
that its contents make. What the log holds (`counts`) are its topics; a message that was made stands
among them where it is asked for by name, as in `select(types=["ATTITUDE"])`.
"""

from collections.abc import Iterable
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.columns.log import Log
from flightstack.logs.columns.placement import PLACES, OnboardSource, Placed, Placement, index_of
from flightstack.logs.columns.table import Table
from flightstack.logs.dialect.message_types import ids_by_name
from flightstack.logs.errors import UnknownNameError
from flightstack.logs.nearest import did_you_mean
from flightstack.logs.onboard.topics import OnboardRecords
from flightstack.logs.tlog.packets import Packets

if TYPE_CHECKING:
    from flightstack.logs.tlog.damage import Damage
    from flightstack.logs.tlog.losses import SourceLoss


class OnboardLog(Log):
    """A vehicle's own log: a Log whose messages are topics, and MAVLink where it is asked for."""

    source: OnboardSource
    is_telemetry = False

    def __init__(self, placement: Placement, packets: Packets, time_us: NDArray[np.int64]) -> None:
        records = placement.records
        super().__init__(OnboardSource(records.name, records.size), packets, time_us)
        self._placement = placement

    @property
    def records(self) -> OnboardRecords:
        """What was read from the file."""
        return self._placement.records

    @property
    def boot_offset_us(self) -> int:
        """The log's time minus the time since the vehicle's boot."""
        return self.records.utc_offset_us

    @property
    def whole(self) -> Log:
        """The log with all of its records, whatever was selected of it."""
        return OnboardLog(self._placement, self._placement.packets, self._placement.time_us)

    def __contains__(self, name: object) -> bool:
        return name in self.counts or (
            isinstance(name, str) and name in self.records.makers and len(self[name]) > 0
        )

    def __getitem__(self, name: str) -> Table:
        """Return a topic, or the MAVLink message that topics make; UnknownNameError for neither."""
        placed = self._placement.message(self.name_known(name))
        if placed.type.id not in self._tables:
            self._tables[placed.type.id] = self._table(placed)
        return self._tables[placed.type.id]

    def _table(self, placed: Placed) -> Table:
        own = np.flatnonzero(self.packets.msgid == placed.type.id)
        if len(own) or placed.type.name in self._placement.topics:
            place = np.searchsorted(placed.offset, self.packets.offset[own])
            packets = self.packets.take(own)
            return Table(placed.type, packets, self.time_us[own], own, placed.data[place])
        anchor = placed.offset // PLACES * PLACES
        row = np.searchsorted(self.packets.offset, anchor)
        held = np.append(self.packets.offset, -1)[row] == anchor
        ids = np.full(int(held.sum()), placed.type.id, dtype=np.uint32)
        packets = index_of(placed.offset[held], placed.time_us[held], ids, self.records.system)
        return Table(placed.type, packets, placed.time_us[held], row[held], placed.data[held])

    def name_known(self, name: str) -> str:
        """Return a name that is a topic or a message; UnknownNameError names the nearest."""
        if name not in self._placement.topics and name not in ids_by_name():
            hint = did_you_mean(name, [*self._placement.topics, *self.records.makers])
            raise UnknownNameError(f"{self.name} holds no topic or message {name!r}{hint}")
        return name

    def name_of(self, msgid: int) -> str:
        """Return the name of the messages with this id."""
        return self._placement.names[msgid]

    def id_of(self, name: str) -> int:
        """Return the id of a topic or message."""
        return self._placement.message(self.name_known(name)).type.id

    @property
    def losses(self) -> "tuple[SourceLoss, ...]":
        """Nothing: no link lies between the vehicle and its own log."""
        return ()

    @property
    def damage(self) -> "Damage":
        """What the file has lost."""
        from flightstack.logs.tlog.damage import Damage, Region  # noqa: PLC0415  # few ask for it

        regions = tuple(
            Region(
                offset=lost.offset, length=lost.length, kind=lost.kind,
                time_us=lost.boot_us + self.boot_offset_us,
            )
            for lost in self.records.lost
        )  # fmt: skip
        return Damage(
            regions=regions, has_times=True, mended_times=0, jumps=(), duplicates=0, line_ends=""
        )

    def load(self, names: Iterable[str]) -> None:
        """Make the tables of several types."""
        for name in names:
            self[name]

    def payloads(self, name: str) -> list[bytes]:
        """Return the records as bytes."""
        return [row.tobytes() for row in self[name].data]

    def mapped(self) -> Log:
        """Return the log itself: it is in memory."""
        return self

    def rows(self, rows: NDArray[np.bool_] | NDArray[np.intp] | slice) -> Log:
        """Return the part of the log with these records."""
        return OnboardLog(self._placement, self.packets.take(rows), self.time_us[rows])

    def select(
        self,
        *,
        types: Iterable[str] | None = None,
        system: int | None = None,
        component: int | None = None,
        start_us: int | None = None,
        end_us: int | None = None,
    ) -> Log:
        """Return the part that passes all filters, as of any log; `types` may name messages, too.

        A wildcard means the topics that match it, and messages only where no topic does.
        """
        patterns = None if types is None else list(types)
        made = [] if patterns is None else self._asked_for(patterns)
        log = self._including(made) if made else self
        return Log.select(
            log, types=patterns, system=system, component=component, start_us=start_us,
            end_us=end_us,
        )  # fmt: skip

    def _asked_for(self, patterns: Iterable[str]) -> list[str]:
        """Return the messages that the patterns ask for, and that are not yet among the records."""
        found = []
        for pattern in patterns:
            if any(fnmatchcase(name, pattern) for name in self.counts):
                continue
            makers = [name for name in self.records.makers if fnmatchcase(name, pattern)]
            found += makers or [self.name_known(pattern)]
        return [name for name in dict.fromkeys(found) if len(self[name])]

    def _including(self, names: Iterable[str]) -> "OnboardLog":
        """Return the log with these messages among its records."""
        parts = [self.packets, *(self[name].packets for name in names)]
        offset = np.concatenate([part.offset for part in parts])
        order = np.argsort(offset, kind="stable")
        times = np.concatenate([part.time_us for part in parts])[order]
        ids = np.concatenate([part.msgid for part in parts])[order]
        packets = index_of(offset[order], times, ids, self.records.system)
        return OnboardLog(self._placement, packets, times)

    def matching_ids(self, patterns: Iterable[str]) -> list[int]:
        """Return the ids of the log's messages that match one of the names or wildcards."""
        patterns = list(patterns)
        for pattern in patterns:
            known = [*self.counts, *self._placement.topics, *ids_by_name()]
            if not any(fnmatchcase(name, pattern) for name in known):
                self.name_known(pattern)
        held = {name: self.id_of(name) for name in self.counts}
        return [held[n] for n in held if any(fnmatchcase(n, pattern) for pattern in patterns)]


def open_onboard(records: OnboardRecords) -> OnboardLog:
    """Return a vehicle's own log."""
    placement = Placement(records)
    return OnboardLog(placement, placement.packets, placement.time_us)
