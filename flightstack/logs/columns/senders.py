"""Tell who is who in a log: which senders are autopilots, and what the others are.

A sender is what its HEARTBEAT says it is, unless its component number belongs to a ground station;
HIGH_LATENCY messages stand for the heartbeat of an autopilot on a narrow link.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.columns.log import Log
from flightstack.logs.columns.table import Table
from flightstack.logs.dialect.message_types import message_id
from flightstack.logs.errors import UnknownNameError
from flightstack.logs.tlog.packets import tally

AUTOPILOT_GENERIC, AUTOPILOT_INVALID = 0, 8  # MAV_AUTOPILOT
AUTOPILOT_COMPONENT = 1  # MAV_COMP_ID_AUTOPILOT1
GROUND_COMPONENTS = (190, 195)  # MAV_COMP_ID_MISSIONPLANNER and the path planner beside it
GROUND_SYSTEMS = 240  # ground stations number themselves from here on
DEVICES = {  # MAV_TYPE of what is no vehicle
    6: "ground station",
    18: "companion",
    26: "gimbal",
    27: "ADS-B receiver",
    30: "camera",
    31: "charging station",
    32: "FLARM receiver",
    33: "servo",
    34: "remote ID",
    36: "battery",
    37: "parachute",
    38: "log",
    39: "display",
    40: "IMU",
    41: "GPS",
    42: "winch",
    44: "lamps",
    46: "radio",
}
COMPONENTS = {  # MAV_COMPONENT, where no heartbeat tells
    **dict.fromkeys(range(100, 106), "camera"),
    **dict.fromkeys((154, *range(171, 176)), "gimbal"),
    **dict.fromkeys((156, 157), "ADS-B receiver"),
    **dict.fromkeys(range(140, 154), "servo"),
    **dict.fromkeys(range(191, 195), "companion"),
    **dict.fromkeys(range(25, 100), "user component"),
    **dict.fromkeys((220, 221), "GPS"),
    68: "telemetry radio",
    158: "peripheral",
    161: "parachute",
    169: "winch",
    180: "battery",
    190: "ground station",
    195: "path planner",
    197: "visual odometry",
    236: "remote ID",
    240: "bridge",
    250: "autopilot's system",
}
BEATS = ("HEARTBEAT", "HIGH_LATENCY2", "HIGH_LATENCY")  # where the type of a sender stands
FLIGHT_DATA = ("ATTITUDE", "GLOBAL_POSITION_INT", "LOCAL_POSITION_NED", "SYS_STATUS", "VFR_HUD")
ECHOED = ("DEBUG", "DEBUG_VECT", "DEBUG_FLOAT_ARRAY", "NAMED_VALUE_FLOAT", "NAMED_VALUE_INT")


@dataclass(frozen=True, slots=True, kw_only=True)
class Participant:
    """One sender of a log, and what it is."""

    system: int
    component: int
    messages: int
    autopilot: int | None  # MAV_AUTOPILOT and MAV_TYPE as its heartbeat says; None without one
    type: int | None
    role: str  # "autopilot", or what else it is
    tells_flight: bool  # it sends attitude, position or state as a vehicle does

    @property
    def is_autopilot(self) -> bool:
        """Whether it flies something."""
        return self.role == "autopilot"

    def rank(self) -> tuple[bool, bool, bool, int]:
        """Return what is compared to choose the vehicle of a log: the largest is it."""
        named = self.autopilot not in (AUTOPILOT_GENERIC, None)
        return (self.tells_flight, self.component == AUTOPILOT_COMPONENT, named, self.messages)


def _told(log: Log) -> dict[int, tuple[int, int]]:
    """Return autopilot and type that each sender's latest beat tells, by sender."""
    found: dict[int, tuple[int, int]] = {}
    for name in BEATS:
        if name not in log:
            continue
        table = log[name]
        senders = table.packets.sender
        for sender in np.unique(senders).tolist():
            row = int(np.flatnonzero(senders == sender)[-1])
            kind = int(table["type"][row]) if "type" in table else 0
            autopilot = int(table["autopilot"][row]) if "autopilot" in table else AUTOPILOT_GENERIC
            found.setdefault(sender, (autopilot, kind))
    return found


def _role(sender: int, told: tuple[int, int] | None, *, tells_flight: bool) -> str:
    system, component = sender >> 8, sender & 0xFF
    if told is not None and component not in GROUND_COMPONENTS:
        autopilot, kind = told
        if kind in DEVICES:
            return DEVICES[kind]
        is_named = autopilot != AUTOPILOT_GENERIC or system < GROUND_SYSTEMS
        if autopilot != AUTOPILOT_INVALID and (is_named or tells_flight):
            return "autopilot"
    by_system = "ground station" if system >= GROUND_SYSTEMS else "unknown"
    return COMPONENTS.get(component, by_system)


def find_participants(log: Log) -> list[Participant]:
    """Return every sender of a log, in order of system and component."""
    told = _told(log)
    sender = log.packets.sender
    tells = _flight_tellers(log, sender)
    return [
        Participant(
            system=key >> 8,
            component=key & 0xFF,
            messages=count,
            autopilot=told[key][0] if key in told else None,
            type=told[key][1] if key in told else None,
            role=_role(key, told.get(key), tells_flight=key in tells),
            tells_flight=key in tells,
        )
        for key, count in tally(sender).items()
    ]


def _flight_tellers(log: Log, sender: NDArray[np.uint16]) -> set[int]:
    """Return the senders of a message of flight."""
    found: set[int] = set()
    for name in FLIGHT_DATA:
        if name in log:
            found.update(tally(sender[log.packets.msgid == message_id(name)]))
    return found


def autopilots(participants: list[Participant]) -> list[Participant]:
    """Return the autopilots, the one that flies most likely first, one a system."""
    ranked = sorted(
        (each for each in participants if each.is_autopilot), key=Participant.rank, reverse=True
    )
    first = {each.system: each for each in reversed(ranked)}
    return [each for each in ranked if first[each.system] is each]


def main_autopilot(participants: list[Participant], system: int | None) -> Participant | None:
    """Return the autopilot of a log, or of one system in it; None without one.

    UnknownNameError where the log holds nothing of that system.
    """
    systems = sorted({each.system for each in participants})
    if system is not None and system not in systems:
        held = ", ".join(map(str, systems))
        raise UnknownNameError(f"no system {system} in the log: it holds {held}; change --system")
    found = autopilots(participants)
    return next((each for each in found if system in (None, each.system)), None)


def of_vehicle(table: Table, vehicle: Participant | None) -> Table:
    """Return the vehicle's messages of a type: its autopilot's, else its system's, else all.

    What a companion sends to be recorded, an autopilot may echo: then the companion's are taken.
    """
    if vehicle is None or not len(table):
        return table
    ours = table.system == vehicle.system
    by_autopilot = ours & (table.component == vehicle.component)
    order: tuple[NDArray[np.bool_], ...] = (by_autopilot, ours)
    if table.name in ECHOED:
        order = (ours & ~by_autopilot, ~by_autopilot, by_autopilot)
    keep = next((rows for rows in order if rows.any()), None)
    return table if keep is None or keep.all() else table.take(keep)
