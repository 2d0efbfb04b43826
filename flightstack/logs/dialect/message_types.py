"""MAVLink message types as numpy layouts, built from pymavlink's own definitions.

Bytes lie on the wire in the order of `dtype`; fields are presented in the order of the message's
definition, extensions last.
"""

from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.dialect.definitions import definitions, mavlink
from flightstack.logs.errors import UnknownNameError
from flightstack.logs.nearest import did_you_mean

MSGID_LIMIT = 1 << 24  # message ids of MAVLink 2 have 24 bits
OTHER_DEFINITION = MSGID_LIMIT  # this bit marks a known id under a definition that is not ours


class Field(NamedTuple):
    """One field of a message: what it is called, counted in, and how it lies on the wire."""

    name: str
    unit: str  # as MAVLink writes it, "" where it has none
    enum: str  # name of the enumeration, "" where it has none
    is_bitmask: bool
    is_text: bool
    length: int  # number of elements, 0 for a plain number


@dataclass(frozen=True, slots=True, kw_only=True, eq=False, repr=False)
class MessageType:
    """One message of the dialect."""

    id: int
    name: str
    crc_extra: int
    size: int  # bytes of an untrimmed payload, extensions included
    dtype: np.dtype[np.void]  # wire order, packed
    fields: tuple[Field, ...]  # in the order of the definition

    def field(self, name: str) -> Field:
        """Return the field called `name`; UnknownNameError names the nearest ones."""
        for field in self.fields:
            if field.name == name:
                return field
        names = [field.name for field in self.fields]
        raise UnknownNameError(f"{self.name} has no field {name!r}{did_you_mean(name, names)}")


def _layout(wire: list[tuple[str, str, int]]) -> np.dtype[np.void]:
    return np.dtype(
        [(name, kind, (count,)) if count > 1 else (name, kind) for name, kind, count in wire]
    )


@cache
def message_type(msgid: int) -> MessageType | None:
    """Return the message type with this id, None where the dialect has none."""
    definition = definitions().get(msgid)
    if definition is None:
        return None
    return MessageType(
        id=msgid,
        name=definition.name,
        crc_extra=definition.crc_extra,
        size=definition.size,
        dtype=_layout(definition.wire_values()),
        fields=tuple(Field(*values) for values in definition.field_values()),
    )


@cache
def ids_by_name() -> dict[str, int]:
    """Return the id of every message name of the dialect."""
    return {definition.name: msgid for msgid, definition in definitions().items()}


def message_name(msgid: int) -> str:
    """Return the name of a message id; UNKNOWN_<id> where the dialect has no such definition."""
    definition = definitions().get(msgid)
    return f"UNKNOWN_{msgid % MSGID_LIMIT}" if definition is None else definition.name


def message_id(name: str) -> int:
    """Return the id of a message, UNKNOWN_<id> included; UnknownNameError names the nearest."""
    found = ids_by_name().get(name)
    if found is not None:
        return found
    unknown = name.removeprefix("UNKNOWN_")
    if unknown != name and unknown.isdigit() and int(unknown) < MSGID_LIMIT:
        msgid = int(unknown)
        return msgid | OTHER_DEFINITION if msgid in definitions() else msgid
    raise UnknownNameError(
        f"no MAVLink message is called {name!r}{did_you_mean(name, ids_by_name())}"
    )


class PacketTables(NamedTuple):
    """What the search for packets must know of every id, for vectorised look-up."""

    ids: NDArray[np.uint32]  # sorted
    crc_extra: NDArray[np.uint16]  # of ids
    size: NDArray[np.int64]  # of ids
    base_size: NDArray[np.int64]  # of ids, without extensions
    row_of_low_id: NDArray[np.int32]  # (65536,) row in ids, -1 where unknown


@cache
def packet_tables() -> PacketTables:
    """Return the tables that the search looks message ids up in."""
    ids = sorted(definitions())
    rows = [definitions()[msgid] for msgid in ids]
    row_of_low_id = np.full(1 << 16, -1, dtype=np.int32)
    low = [msgid for msgid in ids if msgid < 1 << 16]
    row_of_low_id[low] = np.arange(len(low))
    return PacketTables(
        ids=np.array(ids, dtype=np.uint32),
        crc_extra=np.array([row.crc_extra for row in rows], dtype=np.uint16),
        size=np.array([row.size for row in rows], dtype=np.int64),
        base_size=np.array([row.base_size for row in rows], dtype=np.int64),
        row_of_low_id=row_of_low_id,
    )


def enum_name(enum: str, value: int) -> str:
    """Return the name of an enumeration's value without the common prefix of its enumeration."""
    entry = mavlink().enums.get(enum, {}).get(value)
    return str(value) if entry is None else str(entry.name)
