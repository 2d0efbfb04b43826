"""Where every packet of a log lies: one row a packet, as arrays."""

from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flightstack.mavlink_numbers import (
    CHECKSUM_BYTES,
    HEADER_V1,
    HEADER_V2,
    MAGIC_V1,
    MAGIC_V2,
    SIGNATURE_BYTES,
    SIGNED_FLAG,
)

MANY_VALUES = 1 << 16  # up to here a value is found faster by counting than by sorting
NO_TIME = np.iinfo(np.int64).min  # time_us of a record whose eight bytes of time are lost


TIMESTAMP = 8
MAX_PACKET = HEADER_V2 + 255 + CHECKSUM_BYTES + SIGNATURE_BYTES
MARGIN = 2 * (MAX_PACKET + TIMESTAMP)  # what starts so far before an end has its neighbour whole

IS_V2 = 1  # bits of Packets.flags
IS_SIGNED = 2
IS_UNKNOWN = 4  # its id is not in the dialect


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class Packets:
    """The index of a log, in file order; all arrays have one entry a packet."""

    offset: NDArray[np.int64]  # of the packet's first byte (0xFD or 0xFE) in the file
    time_us: NDArray[np.int64]  # since 1970, as recorded, or NO_TIME
    msgid: NDArray[np.uint32]
    system: NDArray[np.uint8]
    component: NDArray[np.uint8]
    sequence: NDArray[np.uint8]
    length: NDArray[np.uint8]  # bytes of payload on the wire
    flags: NDArray[np.uint8]
    extra: NDArray[np.uint8]  # CRC_EXTRA that the checksum was made with

    def __len__(self) -> int:
        return len(self.offset)

    def take(self, rows: NDArray[np.intp] | NDArray[np.bool_] | slice) -> "Packets":
        """Return the packets of these rows."""
        return Packets(**{field.name: getattr(self, field.name)[rows] for field in fields(self)})

    @property
    def sender(self) -> NDArray[np.uint16]:
        """System and component of each packet in one number, system << 8 | component."""
        return self.system.astype(np.uint16) << np.uint16(8) | self.component

    @property
    def header_length(self) -> NDArray[np.uint8]:
        """Bytes before each payload."""
        return np.where(self.flags & IS_V2, np.uint8(HEADER_V2), np.uint8(HEADER_V1))

    @property
    def end(self) -> NDArray[np.int64]:
        """Offset of the first byte after each packet, its signature included."""
        signed = self.flags & IS_SIGNED
        tail = np.where(
            signed, np.uint8(CHECKSUM_BYTES + SIGNATURE_BYTES), np.uint8(CHECKSUM_BYTES)
        )
        ends = self.offset + self.length
        ends += self.header_length + tail
        return ends


def tally(column: NDArray[np.unsignedinteger[Any]]) -> dict[int, int]:
    """Return how often each value stands in a column of an index, in order of value."""
    if not len(column) or int(column.max()) >= MANY_VALUES:
        values, counts = np.unique(column, return_counts=True)
    else:
        every = np.bincount(column)
        values = np.flatnonzero(every)
        counts = every[values]
    return dict(zip(values.tolist(), counts.tolist(), strict=True))


def packet_length(head: NDArray[np.uint8]) -> int:
    """Return how many bytes the packet has that starts with `head`, 0 where none starts so."""
    if len(head) < 3:
        return 0
    magic, length, incompatible = head[:3].tolist()
    if magic == MAGIC_V1:
        return int(HEADER_V1 + length + CHECKSUM_BYTES)
    if magic == MAGIC_V2 and incompatible <= SIGNED_FLAG:
        return int(HEADER_V2 + length + CHECKSUM_BYTES + SIGNATURE_BYTES * incompatible)
    return 0


def no_packets() -> Packets:
    """Return an empty index."""
    byte = np.empty(0, dtype=np.uint8)
    wide = np.empty(0, dtype=np.int64)
    return Packets(
        offset=wide,
        time_us=wide,
        msgid=np.empty(0, dtype=np.uint32),
        system=byte,
        component=byte,
        sequence=byte,
        length=byte,
        flags=byte,
        extra=byte,
    )


def join(parts: list[Packets]) -> Packets:
    """Return all parts as one index, emptying `parts` on the way so that memory stays bounded."""
    if not parts:
        return no_packets()
    names = [field.name for field in fields(Packets)]
    columns = {name: [getattr(part, name) for part in parts] for name in names}
    parts.clear()  # from here on, each column's pieces go as soon as they are joined
    return Packets(**{name: np.concatenate(columns.pop(name)) for name in names})
