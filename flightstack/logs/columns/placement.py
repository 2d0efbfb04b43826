"""Put the records of a vehicle's own log in one order, and make messages of them when asked."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.dialect.message_types import (
    MSGID_LIMIT,
    MessageType,
    message_id,
    message_type,
)
from flightstack.logs.errors import LogFileError, UnknownNameError
from flightstack.logs.onboard.topics import Made, OnboardRecords
from flightstack.logs.tlog.packets import Packets

AUTOPILOT = 1  # MAV_COMP_ID_AUTOPILOT1
PLACES = 256  # a record's number times this is its offset; made messages stand right behind it


@dataclass(frozen=True, slots=True, eq=False)
class OnboardSource:
    """Stands in for the bytes of a tlog, of which a vehicle's own log has none."""

    name: str
    size: int

    def read(self, start: int, stop: int) -> NDArray[np.uint8]:
        """Refuse with LogFileError: there are no packets."""
        raise LogFileError(
            f"{self.name} holds no MAVLink packets ({start} to {stop}): use the command export"
        )


@dataclass(frozen=True, slots=True, eq=False)
class Placed:
    """All messages of one kind with their places in the log."""

    type: MessageType
    offset: NDArray[np.int64]  # increasing
    time_us: NDArray[np.int64]
    data: NDArray[np.void]


def index_of(offset: NDArray[np.int64], times: NDArray[np.int64], ids: NDArray[np.uint32],
             system: int) -> Packets:  # fmt: skip
    """Return an index of records, all of one system's autopilot; of each array one entry each."""
    zeros = np.zeros(len(offset), dtype=np.uint8)
    return Packets(
        offset=offset, time_us=times, msgid=ids, system=zeros + np.uint8(system),
        component=zeros + np.uint8(AUTOPILOT), sequence=zeros, length=zeros, flags=zeros,
        extra=zeros,
    )  # fmt: skip


def _type(number: int, name: str, records: OnboardRecords) -> MessageType:
    topic = records.topics[name]
    return MessageType(
        id=MSGID_LIMIT + number,
        name=name,
        crc_extra=0,
        size=topic.data.dtype.itemsize,
        dtype=topic.data.dtype,
        fields=topic.fields,
    )


class Placement:
    """Puts all records of a file in one order, and makes messages when they are asked for."""

    def __init__(self, records: OnboardRecords) -> None:
        self.records = records
        topics = list(records.topics.values())
        sizes = [len(topic) for topic in topics]
        boot_us = np.concatenate([topic.boot_us for topic in topics])
        order = np.argsort(boot_us, kind="stable")
        place = np.empty(len(order), dtype=np.int64)
        place[order] = np.arange(len(order)) * PLACES
        self.time_us = boot_us[order] + records.utc_offset_us
        ids = np.repeat(np.arange(len(topics), dtype=np.uint32) + np.uint32(MSGID_LIMIT), sizes)
        self.packets = index_of(np.sort(place), self.time_us, ids[order], records.system)
        self.placed: dict[str, Placed] = {}
        for number, (topic, offset) in enumerate(
            zip(topics, np.split(place, np.cumsum(sizes)[:-1]), strict=True)
        ):
            times = topic.boot_us + records.utc_offset_us
            kind = _type(number, topic.name, records)
            self.placed[topic.name] = Placed(kind, offset, times, topic.data)
        self.names = {placed.type.id: name for name, placed in self.placed.items()}
        self.topics = tuple(self.placed)

    def message(self, name: str) -> Placed:
        """Return a topic, or a message of the dialect; none of it where nothing makes it."""
        if name not in self.placed:
            msgid = message_id(name)
            known = message_type(msgid)
            if known is None:
                raise UnknownNameError(f"{self.records.name} holds no message {name}")
            maker = self.records.makers.get(name)
            made = maker(self.records) if maker is not None else None
            self.placed[name] = self._place(known, made)
            self.names[msgid] = name
        return self.placed[name]

    def _place(self, kind: MessageType, made: Made | None) -> Placed:
        """Put each made message right behind the last record of its time."""
        if made is None:
            none = np.empty(0, dtype=np.int64)
            return Placed(kind, none, none, np.empty(0, dtype=kind.dtype))
        times = made.boot_us + self.records.utc_offset_us
        row = np.maximum(np.searchsorted(self.time_us, times, side="right") - 1, 0)
        same = np.arange(len(row)) - np.searchsorted(row, row)  # how many stand there already
        offset = self.packets.offset[row] + 1 + np.minimum(same, PLACES - 2)
        return Placed(kind, offset, times, made.data)
