"""Turn what happens in flight into lines: phases, gates, the vehicle's own words, what is wrong."""

import math
import traceback
from collections.abc import Mapping
from typing import Protocol

from pymavlink.dialects.v20 import common

from flightstack.companion.console import Console
from flightstack.companion.mission.records import MissionPhase, MissionStatus, Outcome
from flightstack.companion.vehicle_session import VehicleSession
from flightstack.mavlink.commands import CommandRefusal, command_name
from flightstack.mavlink.telemetry import Telemetry
from flightstack.mavlink.uncertainty import total_std_m_s
from flightstack.mavlink_numbers import COMPANION_COMPONENT
from flightstack.px4_modes import spoken_name
from flightstack.records import Decision

MAX_WARNINGS = 100  # different ones: whatever is wrong has then been said
WARNING_SEVERITY = 4  # MAV_SEVERITY_WARNING; a smaller number is more urgent


class Keeper(Protocol):
    """Something that keeps what happens on a disk."""

    @property
    def failure(self) -> str | None:
        """Why it keeps no more, or not all."""


class Reporter:
    """Compare each turn of the loop with the one before, and tell the difference."""

    def __init__(self, console: Console) -> None:
        self._console = console
        self._keepers: list[Keeper] = []
        self._phase: MissionPhase | None = None
        self._gates_passed = 0
        self._decision: Decision | None = None
        self._warned: set[str] = set()
        self._named: set[int] = set()  # other components

    def note_decision(self, decision: Decision) -> None:
        """Remember the newest decision: its uncertainty is told with the next gate."""
        self._decision = decision

    def warn_once(self, text: str) -> None:
        """Tell of something wrong, the first time only."""
        if text not in self._warned and len(self._warned) < MAX_WARNINGS:
            self._warned.add(text)
            self._console.warning(text)

    def warn_of_error(self, error: Exception) -> None:
        """Tell of an error of our own, each once, and with --verbose from where it came."""
        self.warn_once(f"an error of the companion's own, please report it: {error!r}")
        self._console.detail("".join(traceback.format_exception(error)))

    def watch(self, keeper: Keeper) -> None:
        """Tell, too, when this one fails."""
        self._keepers.append(keeper)

    def report_failures(self) -> None:
        """Tell of a disk that fails us, each failure once."""
        for keeper in self._keepers:
            if keeper.failure is not None:
                self.warn_once(keeper.failure)

    def report(self, status: MissionStatus, vehicle: VehicleSession) -> None:
        """Tell what is new."""
        telemetry = vehicle.telemetry
        for text in vehicle.drain_texts():
            tell = (
                self._console.event if text.severity <= WARNING_SEVERITY else self._console.detail
            )
            tell(f"vehicle: {text.text}")
        for refusal in vehicle.drain_refusals():
            tell = self._console.detail if _is_question(refusal) else self._console.event
            tell(f"{command_name(refusal.command)}: {refusal.reason}")
        self.report_failures()
        self._name_others(vehicle.link.others)
        for verdict in vehicle.link.refused:
            self.warn_once(f"messages are refused: {verdict.value}")
        if telemetry.course.gates_passed > self._gates_passed:
            self._gates_passed = telemetry.course.gates_passed
            self._console.event(self._flight_line(status, vehicle, self._gates_passed))
        if status.phase is not self._phase:
            self._phase = status.phase
            self._console.close()  # the live line was of the phase before
            self._console.event(_phase_line(status, telemetry))
            if status.phase is MissionPhase.DONE:
                self._warn_of_armed(status, vehicle)
        if status.phase is MissionPhase.FLYING and self._console.wants_live:
            course = telemetry.course
            due = min(course.gates_passed + 1, course.gates_total or 0)
            self._console.live(self._flight_line(status, vehicle, due))

    def _name_others(self, others: Mapping[int, int]) -> None:
        """Name the other computers of this vehicle, once each."""
        for component in others.keys() - self._named:
            self._named.add(component)
            if component == COMPANION_COMPONENT:
                self._console.warning("another companion beats as ours does: see --take-over")
            elif others[component] == common.MAV_TYPE_ONBOARD_CONTROLLER:
                self._console.event(f"another onboard computer is there: component {component}")

    def _warn_of_armed(self, status: MissionStatus, vehicle: VehicleSession) -> None:
        """Tell when a vehicle that was to be landed was not seen disarmed."""
        lost = status.outcome is Outcome.LINK_LOST and vehicle.telemetry.heartbeat_us is None
        if status.lands and (lost or vehicle.telemetry.armed) and status.offboard_us is not None:
            self.warn_once("the vehicle was not seen disarmed: it may still fly")

    def _flight_line(self, status: MissionStatus, vehicle: VehicleSession, gate: int) -> str:
        """Return time, a gate (from 1: the one just passed, or due), speed and uncertainty."""
        telemetry = vehicle.telemetry
        since_us = status.offboard_us
        flown_s = 0.0 if since_us is None else (vehicle.link.clock.stamp_us - since_us) / 1e6
        parts = [f"{flown_s:7.2f} s"]
        if telemetry.course.known:
            parts.append(f"gate {gate}/{telemetry.course.gates_total}")
        if telemetry.velocity_ned is not None:
            parts.append(f"{math.hypot(*telemetry.velocity_ned):4.1f} m/s")
        if self._decision is not None:
            parts.append(f"uncertainty {total_std_m_s(self._decision):.2f} m/s")
        return "   ".join(parts)


def announcement(status: MissionStatus) -> str:
    """Say in one STATUSTEXT where the mission stands."""
    reason = "" if status.outcome is None else f", {status.outcome.value}"
    return f"Companion: {status.phase.name.lower()}{reason}".replace("_", " ")


def _is_question(refusal: CommandRefusal) -> bool:
    """Tell questions, which a vehicle may not be able to answer yet, from orders."""
    return bool(refusal.command.number == common.MAV_CMD_REQUEST_MESSAGE)


def _phase_line(status: MissionStatus, telemetry: Telemetry) -> str:
    if status.phase is MissionPhase.TAKEN_OVER:
        return f"taken over: the vehicle is in {spoken_name(telemetry.custom_mode)}, hands off"
    reason = f" ({status.outcome.value.replace('_', ' ')})" if status.outcome else ""
    return f"{status.phase.value}{reason}"
