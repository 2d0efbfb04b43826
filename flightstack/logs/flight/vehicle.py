"""Find the vehicle of a log, and what its HEARTBEAT says over time: armed, mode, failsafe."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.columns.log import Log
from flightstack.logs.columns.table import Table
from flightstack.logs.dialect.message_types import enum_name
from flightstack.logs.flight.modes import mode_name

AUTOPILOT_INVALID = 8  # MAV_AUTOPILOT_INVALID: a companion, a camera, a ground station
NO_VEHICLES = (6, 18, 26, 27, 30)  # MAV_TYPE: GCS, onboard controller, gimbal, ADS-B, camera
ARMED = 128  # MAV_MODE_FLAG_SAFETY_ARMED
CRITICAL, EMERGENCY, TERMINATION = 5, 6, 8  # MAV_STATE
US = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class Interval:
    """A stretch of time in which something held."""

    label: str
    start_us: int
    end_us: int

    @property
    def duration_s(self) -> float:
        """Length in seconds."""
        return (self.end_us - self.start_us) * US


@dataclass(frozen=True, slots=True, kw_only=True)
class LoggedVehicle:
    """Who flies: the autopilot's system and component, and its kind."""

    system: int
    component: int
    autopilot: int  # MAV_AUTOPILOT
    type: int  # MAV_TYPE

    def sent(self, log: Log, name: str) -> Table:
        """Return the messages of a type that its autopilot sent."""
        return log[name].where(system=self.system, component=self.component)

    @property
    def kind(self) -> str:
        """Autopilot and type for people."""
        autopilot = enum_name("MAV_AUTOPILOT", self.autopilot).removeprefix("MAV_AUTOPILOT_")
        vehicle_type = enum_name("MAV_TYPE", self.type).removeprefix("MAV_TYPE_")
        return f"{autopilot} {vehicle_type}".lower().replace("_", " ")


def find_vehicle(log: Log, system: int | None = None) -> LoggedVehicle | None:
    """Return the autopilot with the most heartbeats, of `system` if given; None without one."""
    beats = log["HEARTBEAT"]
    is_autopilot = (beats["autopilot"] != AUTOPILOT_INVALID) & ~np.isin(beats["type"], NO_VEHICLES)
    if system is not None:
        is_autopilot &= beats.system == system
    beats = beats.take(is_autopilot)
    if not len(beats):
        return None
    senders, counts = np.unique(beats.packets.sender, return_counts=True)
    chosen = int(senders[counts.argmax()])
    row = int(np.flatnonzero(beats.packets.sender == chosen)[-1])
    return LoggedVehicle(
        system=chosen >> 8,
        component=chosen & 0xFF,
        autopilot=int(beats["autopilot"][row]),
        type=int(beats["type"][row]),
    )


def intervals(times: NDArray[np.int64], labels: Sequence[str], end_us: int) -> list[Interval]:
    """Return the stretches of equal labels; each lasts until the next label is seen."""
    found = []
    start = 0
    for row in range(1, len(labels) + 1):
        if row == len(labels) or labels[row] != labels[start]:
            until = end_us if row == len(labels) else int(times[row])
            found.append(Interval(label=labels[start], start_us=int(times[start]), end_us=until))
            start = row
    return found


def mode_intervals(beats: Table, vehicle: LoggedVehicle, end_us: int) -> list[Interval]:
    """Return when the vehicle flew in which mode."""
    base, custom = beats["base_mode"].tolist(), beats["custom_mode"].tolist()
    names: dict[tuple[int, int], str] = {}
    for pair in set(zip(base, custom, strict=True)):
        names[pair] = mode_name(vehicle.autopilot, vehicle.type, *pair)
    labels = [names[pair] for pair in zip(base, custom, strict=True)]
    return intervals(beats.time_us, labels, end_us)


def armed_intervals(beats: Table, end_us: int) -> list[Interval]:
    """Return when the vehicle was armed."""
    labels = np.where(beats["base_mode"] & ARMED, "armed", "disarmed").tolist()
    return [each for each in intervals(beats.time_us, labels, end_us) if each.label == "armed"]


def failsafe_intervals(beats: Table, end_us: int) -> list[Interval]:
    """Return when the vehicle said that it was in a failsafe (MAV_STATE CRITICAL or worse)."""
    names = {CRITICAL: "critical", EMERGENCY: "emergency", TERMINATION: "termination"}
    labels = [names.get(state, "") for state in beats["system_status"].tolist()]
    return [each for each in intervals(beats.time_us, labels, end_us) if each.label]
