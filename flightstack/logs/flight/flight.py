"""A flight: everything that can be said about a log, computed when it is first asked for."""

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.columns.log import Log
from flightstack.logs.columns.table import Table
from flightstack.logs.flight.course import (
    CourseEvent,
    CourseGate,
    find_events,
    find_gates,
    gates_passed,
)
from flightstack.logs.flight.decisions import (
    Decisions,
    MemberPredictions,
    find_decisions,
    find_members,
)
from flightstack.logs.flight.motion import Motion, find_motion
from flightstack.logs.flight.setpoints import (
    Answers,
    VelocitySetpoints,
    camera_answers,
    find_setpoints,
    setpoint_times,
    within,
)
from flightstack.logs.flight.texts import LoggedText, status_texts
from flightstack.logs.flight.tracking import Tracking, response_lag_s, track
from flightstack.logs.flight.vehicle import (
    AUTOPILOT_INVALID,
    Interval,
    LoggedVehicle,
    armed_intervals,
    failsafe_intervals,
    find_vehicle,
    intervals,
    mode_intervals,
)

ALOFT = (2, 3, 4)  # MAV_LANDED_STATE: in the air, taking off, landing
UNKNOWN_VOLTAGE = 65535  # of SYS_STATUS
LIFTED_M = 0.5  # higher than this above where it was armed counts as flying, without landed state
SUMMARY_MESSAGES = (
    "ATTITUDE",
    "AUTOPILOT_VERSION",
    "BATTERY_STATUS",
    "CAMERA_TRIGGER",
    "DEBUG_FLOAT_ARRAY",
    "EXTENDED_SYS_STATE",
    "HEARTBEAT",
    "LOCAL_POSITION_NED",
    "MISSION_CURRENT",
    "MISSION_ITEM_INT",
    "MISSION_ITEM_REACHED",
    "SET_ATTITUDE_TARGET",
    "SET_POSITION_TARGET_GLOBAL_INT",
    "SET_POSITION_TARGET_LOCAL_NED",
    "STATUSTEXT",
    "SYS_STATUS",
)

# stands in for the vehicle of a log without one
NOBODY = LoggedVehicle(system=0, component=0, autopilot=AUTOPILOT_INVALID, type=0)


class Flight:
    """What a log says about one vehicle; without an autopilot in it, `vehicle` is None."""

    def __init__(self, log: Log, system: int | None = None) -> None:
        self.log = log
        log.load(SUMMARY_MESSAGES)
        self.vehicle: LoggedVehicle | None = find_vehicle(log, system)
        self._who = self.vehicle or NOBODY

    @cached_property
    def start_us(self) -> int:
        """Time of the first record."""
        return int(self.log.time_us[0]) if len(self.log) else 0

    @cached_property
    def end_us(self) -> int:
        """Time of the latest record."""
        return int(self.log.time_us.max()) if len(self.log) else 0

    def seconds(self, time_us: int) -> float:
        """Return a time as seconds since the start of the log."""
        return (time_us - self.start_us) * 1e-6

    def of_vehicle(self, name: str) -> Table:
        """Return the messages of a type that the vehicle's autopilot sent."""
        if self.vehicle is None:
            return self.log[name].take(slice(0, 0))
        return self.vehicle.sent(self.log, name)

    @cached_property
    def modes(self) -> list[Interval]:
        """When the vehicle flew in which mode."""
        if self.vehicle is None:
            return []
        return mode_intervals(self.of_vehicle("HEARTBEAT"), self.vehicle, self.end_us)

    @cached_property
    def armed(self) -> list[Interval]:
        """When the vehicle was armed."""
        return armed_intervals(self.of_vehicle("HEARTBEAT"), self.end_us)

    @cached_property
    def offboard(self) -> list[Interval]:
        """When a companion had control while armed: PX4's OFFBOARD, ArduPilot's GUIDED."""
        found = []
        for mode in self.modes:
            for armed in self.armed:
                start_us = max(mode.start_us, armed.start_us)
                end_us = min(mode.end_us, armed.end_us)
                if mode.label in ("OFFBOARD", "GUIDED") and start_us < end_us:
                    found.append(Interval(label=mode.label, start_us=start_us, end_us=end_us))
        return found

    @cached_property
    def failsafes(self) -> list[Interval]:
        """When the vehicle said that it was in a failsafe."""
        return failsafe_intervals(self.of_vehicle("HEARTBEAT"), self.end_us)

    @cached_property
    def flying(self) -> list[Interval]:
        """When the vehicle was in the air: by its landed state, else by its height while armed."""
        states = self.of_vehicle("EXTENDED_SYS_STATE")
        if len(states):
            aloft = np.isin(states["landed_state"], ALOFT)
            labels = np.where(aloft, "flying", "").tolist()
            spans = intervals(states.time_us, labels, self.end_us)
            return [span for span in spans if span.label]
        return [span for armed in self.armed for span in self._lifted(armed)]

    def _lifted(self, armed: Interval) -> list[Interval]:
        part = self.motion.within(armed.start_us, armed.end_us)
        if not len(part):
            return [armed]
        height_m = part.position_ned[0, 2] - part.position_ned[:, 2]
        labels = np.where(height_m > LIFTED_M, "flying", "").tolist()
        spans = intervals(part.time_us, labels, armed.end_us)
        return [span for span in spans if span.label]

    @cached_property
    def ending(self) -> str:
        """How the log ends: landed, on the ground, in the air, or unknown."""
        states = self.of_vehicle("EXTENDED_SYS_STATE")
        if not len(self.of_vehicle("HEARTBEAT")):
            return "unknown: no heartbeat of an autopilot"
        armed = bool(self.armed) and self.armed[-1].end_us >= self.end_us
        if len(states):
            in_air = int(states["landed_state"][-1]) in ALOFT
        else:
            in_air = bool(self.flying) and self.flying[-1].end_us >= self.end_us
        if in_air:
            return "in the air, armed" if armed else "in the air, disarmed"
        if armed:
            return "on the ground, still armed"
        return "landed and disarmed" if self.flying else "never flew"

    @cached_property
    def battery(self) -> Table:
        """The SYS_STATUS that tell a voltage."""
        table = self.of_vehicle("SYS_STATUS")
        volts = table["voltage_battery"]
        return table.take((volts > 0) & (volts != UNKNOWN_VOLTAGE))

    @cached_property
    def texts(self) -> list[LoggedText]:
        """All status texts."""
        return status_texts(self.log)

    @cached_property
    def motion(self) -> Motion:
        """Where the vehicle was and how fast."""
        return find_motion(self.log, self._who)

    @cached_property
    def setpoints(self) -> VelocitySetpoints:
        """The velocity setpoints that were sent."""
        return find_setpoints(self.log, self._who)

    @cached_property
    def offboard_setpoint_times(self) -> NDArray[np.int64]:
        """When setpoints of any kind were sent while OFFBOARD."""
        times = setpoint_times(self.log, self._who)
        return times[within(times, self.offboard)]

    @cached_property
    def answers(self) -> Answers:
        """Camera images and their answers while OFFBOARD."""
        return camera_answers(self.log, self.setpoints, self.offboard)

    @cached_property
    def tracking(self) -> Tracking:
        """Setpoints beside responses while OFFBOARD."""
        return track(self.log, self._who, self.motion, self.setpoints, self.offboard)

    @cached_property
    def response_lags_s(self) -> list[float | None]:
        """By how much the response follows the setpoint, for each velocity."""
        return [response_lag_s(self.tracking, axis) for axis in range(4)]

    @cached_property
    def decisions(self) -> Decisions:
        """The companion's decisions."""
        return find_decisions(self.log)

    @cached_property
    def members(self) -> MemberPredictions:
        """What each member would have commanded."""
        return find_members(self.log)

    @cached_property
    def gates(self) -> list[CourseGate]:
        """The course's gates, where the referee listed them."""
        return find_gates(self.log)

    @cached_property
    def course_events(self) -> list[CourseEvent]:
        """What the referee said."""
        return find_events(self.texts)

    @property
    def first_failure(self) -> CourseEvent | None:
        """The gate that was missed or hit; None where nothing failed."""
        return next((event for event in self.course_events if event.is_failure), None)

    @cached_property
    def gates_passed(self) -> int:
        """How many gates the referee counted."""
        return gates_passed(self.log)
