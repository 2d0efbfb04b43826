"""What a vehicle's own log holds, whoever wrote it: topics, texts, parameters, what was lost."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.dialect.message_types import Field

Floats = NDArray[np.float64]
Times = NDArray[np.int64]


def plain_field(name: str, unit: str, *, is_text: bool, length: int) -> Field:
    """Return a field without an enumeration; length is 0 but for arrays."""
    return Field(name=name, unit=unit, enum="", is_bitmask=False, is_text=is_text, length=length)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Topic:
    """The records of one kind, in order of time."""

    name: str
    fields: tuple[Field, ...]
    boot_us: Times  # (n,) since the vehicle's boot
    data: NDArray[np.void]  # (n,) structured, one entry a field

    def __len__(self) -> int:
        return len(self.boot_us)

    def has(self, *names: str) -> bool:
        """Return whether it has all of these fields."""
        return set(names) <= set(self.data.dtype.names or ())

    def column(self, *names: str) -> Floats:
        """Return the first of these fields that it has, (n,) or (n, length); NaN without any.

        Several names are those that one quantity had in several versions of the firmware.
        """
        for name in names:
            if self.has(name):
                return self.data[name].astype(np.float64)
        return np.full(len(self), np.nan)

    def columns(self, *names: str) -> Floats:
        """Return these fields side by side, (n, number of names); NaN for those it lacks."""
        return np.stack([self.column(name) for name in names], axis=1)


@dataclass(frozen=True, slots=True, kw_only=True)
class TimedText:
    """A text that the vehicle logged."""

    boot_us: int
    severity: int  # MAV_SEVERITY
    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class TimedParameter:
    """A parameter's value from some time on."""

    boot_us: int
    name: str
    value: int | float


@dataclass(frozen=True, slots=True, kw_only=True)
class Dropout:
    """A time in which the logger could not keep up, and wrote nothing."""

    boot_us: int
    duration_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class LostBytes:
    """A stretch of the file that holds no record."""

    offset: int
    length: int
    boot_us: int  # of the last record before it
    kind: str  # "foreign bytes" or "cut"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Made:
    """MAVLink messages that were made from topics; `data` is of the message's dtype."""

    boot_us: Times
    data: NDArray[np.void]


Maker = Callable[["OnboardRecords"], Made | None]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class OnboardRecords:
    """All that one file of a vehicle's own holds."""

    name: str  # its path
    size: int  # bytes
    topics: dict[str, Topic]
    system: int
    utc_offset_us: int  # time since 1970 minus time since boot; 0 where no GPS told the time
    makers: Mapping[str, Maker]  # by the name of the MAVLink message
    texts: tuple[TimedText, ...] = ()
    parameters: tuple[TimedParameter, ...] = ()
    dropouts: tuple[Dropout, ...] = ()
    lost: tuple[LostBytes, ...] = ()
    is_damaged: bool = False
    versions: dict[str, int | str] = field(default_factory=dict)

    def topic(self, *names: str) -> Topic | None:
        """Return the first of these topics that holds a record, None without any."""
        held = (self.topics[name] for name in names if name in self.topics)
        return next((topic for topic in held if len(topic)), None)

    def parameter(self, *names: str) -> float | None:
        """Return the last value of the first of these parameters that the log tells."""
        values = {parameter.name: parameter.value for parameter in self.parameters}
        return next((float(values[name]) for name in names if name in values), None)
