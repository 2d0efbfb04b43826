"""Read a vehicle's parameters from a log, and what changed in flight."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.columns.table import Table
from flightstack.logs.flight.flight import Flight
from flightstack.logs.flight.modes import PX4

BYTEWISE_CAPABILITY = 1 << 4  # MAV_PROTOCOL_CAPABILITY_PARAM_ENCODE_BYTEWISE
INTEGER_TYPES = {1: "u1", 2: "i1", 3: "<u2", 4: "<i2", 5: "<u4", 6: "<i4"}  # MAV_PARAM_TYPE
HASH_CHECK = "_HASH_CHECK"  # PX4's checksum of all, not a parameter

Value = int | float
NONE_KNOWN: Mapping[str, Value] = MappingProxyType({})


@dataclass(frozen=True, slots=True, kw_only=True)
class Change:
    """A parameter that took another value."""

    time_us: int
    name: str
    before: Value
    after: Value


@dataclass(frozen=True, slots=True, kw_only=True)
class LoggedParameters:
    """The last known value of every parameter, and all changes in order."""

    values: dict[str, Value]
    changes: tuple[Change, ...]


def is_bytewise(flight: Flight) -> bool:
    """Return whether integers lie in the bytes of the float (PX4), or are cast (ArduPilot)."""
    version = flight.of_vehicle("AUTOPILOT_VERSION")
    if len(version):
        return bool(version["capabilities"][-1] & np.uint64(BYTEWISE_CAPABILITY))
    return flight.vehicle is None or flight.vehicle.autopilot == PX4


def _values(table: Table, *, bytewise: bool) -> list[Value]:
    raw: NDArray[np.float32] = np.ascontiguousarray(table["param_value"])
    as_bytes = raw.view(np.uint8).reshape(len(raw), 4)
    values: list[Value] = []
    for row, kind in enumerate(table["param_type"].tolist()):
        integer = INTEGER_TYPES.get(kind)
        if integer is None:
            values.append(float(str(raw[row])))  # the shortest decimal of a 32-bit float
        elif bytewise:
            values.append(int(as_bytes[row].view(integer)[0]))
        else:
            values.append(int(raw[row]) if np.isfinite(raw[row]) else float("nan"))
    return values


def _told(flight: Flight) -> Table:
    """Return the PARAM_VALUE of the vehicle.

    A ground station that gets them as a file writes them under its own component of the vehicle's
    system. Gimbals, cameras and the like have parameters of their own.
    """
    table = flight.log["PARAM_VALUE"]
    if flight.autopilot is None:
        return table.take(slice(0, 0))
    vehicle = flight.autopilot
    strangers = {
        each.component
        for each in flight.participants
        if each.system == vehicle.system and each.role not in ("ground station", "unknown")
    } - {vehicle.component}
    ours = (table.system == vehicle.system) & ~np.isin(table.component, list(strangers))
    return table.take(ours)


def read_parameters(flight: Flight, known: Mapping[str, Value] = NONE_KNOWN) -> LoggedParameters:
    """Return the parameters that the vehicle told, or that were fetched from it as a file.

    `known` are those of before, where the flight is in a part of a log.
    """
    table = _told(flight)
    names = table["param_id"].tolist()
    latest = dict(known)
    changes = []
    rows = zip(
        table.time_us.tolist(), names, _values(table, bytewise=is_bytewise(flight)), strict=True
    )
    for time_us, name, value in rows:
        if name == HASH_CHECK:
            continue
        if name in latest and latest[name] != value:
            changes.append(Change(time_us=time_us, name=name, before=latest[name], after=value))
        latest[name] = value
    return LoggedParameters(values=dict(sorted(latest.items())), changes=tuple(changes))
