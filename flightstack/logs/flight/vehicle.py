"""Say what a log's vehicle is, and what its HEARTBEAT says over time: armed, mode, failsafe."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.columns.log import Log
from flightstack.logs.columns.senders import Participant
from flightstack.logs.columns.table import Table
from flightstack.logs.dialect.message_types import enum_name
from flightstack.logs.flight.modes import mode_name

ARMED = 128  # MAV_MODE_FLAG_SAFETY_ARMED
CUSTOM_MODE_ENABLED = 1  # MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
CRITICAL, EMERGENCY, TERMINATION = 5, 6, 8  # MAV_STATE
PX4 = 12  # MAV_AUTOPILOT_PX4
US = 1e-6


@dataclass(frozen=True, slots=True, kw_only=True)
class Interval:
    """A stretch of time in which something held."""

    label: str
    start_us: int
    end_us: int
    is_from_start: bool = False  # it held when it was first told of
    is_open: bool = False  # it still held when it was last told of

    @property
    def duration_s(self) -> float:
        """Length in seconds."""
        return (self.end_us - self.start_us) * US

    def until(self, end_us: int, *, is_open: bool) -> "Interval":
        """Return the stretch with another end."""
        return replace(self, end_us=end_us, is_open=is_open)

    def called(self, label: str) -> "Interval":
        """Return the stretch under another name."""
        return replace(self, label=label)


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
        return kind_name(self.autopilot, self.type)


@cache
def kind_name(autopilot: int, vehicle_type: int) -> str:
    """Return autopilot and type for people."""
    firmware = enum_name("MAV_AUTOPILOT", autopilot).removeprefix("MAV_AUTOPILOT_")
    name = enum_name("MAV_TYPE", vehicle_type).removeprefix("MAV_TYPE_")
    return f"{firmware} {name}".lower().replace("_", " ")


def vehicle_of(participant: Participant | None) -> LoggedVehicle | None:
    """Return the vehicle that an autopilot flies; None without one."""
    if participant is None or participant.autopilot is None or participant.type is None:
        return None
    return LoggedVehicle(
        system=participant.system,
        component=participant.component,
        autopilot=participant.autopilot,
        type=participant.type,
    )


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class States:
    """What an autopilot said of itself, in order of time: from heartbeats, else high latency."""

    time_us: NDArray[np.int64]
    base_mode: NDArray[np.uint8]
    custom_mode: NDArray[np.uint32]
    status: NDArray[np.uint8]  # MAV_STATE
    tells_armed: bool

    def __len__(self) -> int:
        return len(self.time_us)


def _states(table: Table, base: NDArray[np.uint8], status: NDArray[np.uint8]) -> States:
    return States(
        time_us=table.time_us,
        base_mode=base,
        custom_mode=table["custom_mode"].astype(np.uint32),
        status=status,
        tells_armed=True,
    )


def find_states(log: Log, vehicle: LoggedVehicle) -> States:
    """Return what the vehicle's autopilot said of itself."""
    beats = vehicle.sent(log, "HEARTBEAT")
    if len(beats):
        return _states(beats, beats["base_mode"], beats["system_status"])
    slow = vehicle.sent(log, "HIGH_LATENCY")
    if len(slow):
        return _states(slow, slow["base_mode"], np.zeros(len(slow), dtype=np.uint8))
    slow = vehicle.sent(log, "HIGH_LATENCY2")
    base = np.full(len(slow), CUSTOM_MODE_ENABLED, dtype=np.uint8)
    states = _states(slow, base, np.zeros(len(slow), dtype=np.uint8))
    shift = 16 if vehicle.autopilot == PX4 else 0  # PX4 sends main and sub mode alone
    return replace(states, custom_mode=states.custom_mode << np.uint32(shift), tells_armed=False)


def intervals(
    times: NDArray[np.int64], labels: Sequence[str], end_us: int, *, is_open: bool = True
) -> list[Interval]:
    """Return the stretches of equal labels; each lasts until the next label is seen.

    The last one ends at `end_us`; `is_open` says whether it went on then.
    """
    found = []
    start = 0
    for row in range(1, len(labels) + 1):
        if row == len(labels) or labels[row] != labels[start]:
            is_last = row == len(labels)
            found.append(
                Interval(
                    label=labels[start],
                    start_us=int(times[start]),
                    end_us=end_us if is_last else int(times[row]),
                    is_from_start=start == 0,
                    is_open=is_last and is_open,
                )
            )
            start = row
    return found


def mode_intervals(states: States, vehicle: LoggedVehicle, end_us: int) -> list[Interval]:
    """Return when the vehicle flew in which mode."""
    base, custom = states.base_mode.tolist(), states.custom_mode.tolist()
    names: dict[tuple[int, int], str] = {}
    for pair in set(zip(base, custom, strict=True)):
        names[pair] = mode_name(vehicle.autopilot, vehicle.type, *pair)
    labels = [names[pair] for pair in zip(base, custom, strict=True)]
    return intervals(states.time_us, labels, end_us)


def armed_intervals(states: States, end_us: int) -> list[Interval]:
    """Return when the vehicle was armed."""
    labels = np.where(states.base_mode & ARMED, "armed", "disarmed").tolist()
    return [each for each in intervals(states.time_us, labels, end_us) if each.label == "armed"]


def failsafe_intervals(states: States, end_us: int) -> list[Interval]:
    """Return when the vehicle said that it was in a failsafe (MAV_STATE CRITICAL or worse)."""
    names = {CRITICAL: "critical", EMERGENCY: "emergency", TERMINATION: "termination"}
    labels = [names.get(state, "") for state in states.status.tolist()]
    return [each for each in intervals(states.time_us, labels, end_us) if each.label]
