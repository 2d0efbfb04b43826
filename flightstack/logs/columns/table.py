"""All messages of one type as columns."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.dialect.message_types import Field, MessageType
from flightstack.logs.tlog.packets import IS_SIGNED, IS_V2, Packets

US = 1e-6


def decode_text(raw: bytes) -> str:
    """Return MAVLink text as pymavlink does: up to the first NUL, other bytes replaced."""
    return raw.split(b"\0", 1)[0].decode("ascii", errors="replace")


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Table:
    """The messages of one type in file order; `table["roll"]` is one numpy array of them.

    `row` is each message's place among all packets of the log, so that messages of different
    types can be put in order.
    """

    type: MessageType
    packets: Packets
    time_us: NDArray[np.int64]  # since 1970; lost times repaired
    row: NDArray[np.intp]
    data: NDArray[np.void]  # of type.dtype

    def __len__(self) -> int:
        return len(self.data)

    def __getitem__(self, name: str) -> NDArray[Any]:
        """Return one column: numbers (n,), arrays (n, length) or text (n,)."""
        field = self.type.field(name)
        column = self.data[name]
        if not field.is_text:
            return column
        text = [decode_text(value) for value in column.tolist()]
        return np.array(text, dtype=np.str_) if text else np.empty(0, dtype="<U1")

    def __iter__(self) -> Iterator[str]:
        return iter(self.names)

    def __contains__(self, name: object) -> bool:
        return name in self.names

    @property
    def name(self) -> str:
        """The message's name."""
        return self.type.name

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the columns, in the order of the message's definition."""
        return tuple(field.name for field in self.type.fields)

    @property
    def fields(self) -> tuple[Field, ...]:
        """The columns with units and enumerations."""
        return self.type.fields

    @property
    def units(self) -> dict[str, str]:
        """The unit of each column that has one."""
        return {field.name: field.unit for field in self.type.fields if field.unit}

    @property
    def time_s(self) -> NDArray[np.float64]:
        """Seconds since 1970 (to 0.2 us: what a double holds)."""
        return np.multiply(self.time_us, US, dtype=np.float64)

    @property
    def system(self) -> NDArray[np.uint8]:
        """The sending system of each message."""
        return self.packets.system

    @property
    def component(self) -> NDArray[np.uint8]:
        """The sending component of each message."""
        return self.packets.component

    @property
    def sequence(self) -> NDArray[np.uint8]:
        """The sender's sequence number of each message."""
        return self.packets.sequence

    @property
    def version(self) -> NDArray[np.int64]:
        """1 or 2: the MAVLink version of each packet."""
        return np.where(self.packets.flags & IS_V2, 2, 1)

    @property
    def signed(self) -> NDArray[np.bool_]:
        """Which packets carry a signature (it is not verified: the key is not in the log)."""
        return (self.packets.flags & IS_SIGNED).astype(np.bool_)

    def take(self, rows: NDArray[np.bool_] | NDArray[np.intp] | slice) -> "Table":
        """Return the table of these rows."""
        return Table(
            self.type, self.packets.take(rows), self.time_us[rows], self.row[rows], self.data[rows]
        )

    def where(self, *, system: int | None = None, component: int | None = None) -> "Table":
        """Return the messages of one system, one component, or both."""
        keep = np.ones(len(self), dtype=np.bool_)
        if system is not None:
            keep &= self.system == system
        if component is not None:
            keep &= self.component == component
        return self if keep.all() else self.take(keep)

    def rows(self) -> Iterator[tuple[Any, ...]]:
        """Yield each message as Python values, in the order of `names`."""
        columns = [self[name].tolist() for name in self.names]
        return zip(*columns, strict=True) if columns else iter([()] * len(self))
