"""A flight: everything that can be said about a log, computed when it is first asked for."""

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.columns.boot_clock import clocked_names
from flightstack.logs.columns.log import Log
from flightstack.logs.columns.senders import (
    AUTOPILOT_INVALID,
    Participant,
    autopilots,
    find_participants,
    main_autopilot,
)
from flightstack.logs.columns.table import Table
from flightstack.logs.columns.time_axis import restarts_of
from flightstack.logs.flight.battery import LoggedBattery, find_battery
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
from flightstack.logs.flight.outings import OutingKind, find_outings, kind_of
from flightstack.logs.flight.satellites import GpsQuality, find_gps
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
    Interval,
    LoggedVehicle,
    States,
    armed_intervals,
    failsafe_intervals,
    find_states,
    mode_intervals,
    vehicle_of,
)

TELL_LANDED = ("EXTENDED_SYS_STATE", "HIGH_LATENCY")  # the first that is there
SUMMARY_MESSAGES = (
    "ATTITUDE",
    "AUTOPILOT_VERSION",
    "BATTERY_STATUS",
    "CAMERA_TRIGGER",
    "DEBUG_FLOAT_ARRAY",
    "EXTENDED_SYS_STATE",
    "HEARTBEAT",
    "HIGH_LATENCY",
    "HIGH_LATENCY2",
    "LOCAL_POSITION_NED",
    "MISSION_CURRENT",
    "MISSION_ITEM_INT",
    "MISSION_ITEM_REACHED",
    "PARAM_VALUE",
    "SERVO_OUTPUT_RAW",
    "SET_ATTITUDE_TARGET",
    "SET_POSITION_TARGET_GLOBAL_INT",
    "SET_POSITION_TARGET_LOCAL_NED",
    "STATUSTEXT",
    "SYS_STATUS",
)

STREAM_STEP_US = 1_000_000  # setpoints further apart are single orders
MIN_STREAMED = 5

# stands in for the vehicle of a log without one
NOBODY = LoggedVehicle(system=0, component=0, autopilot=AUTOPILOT_INVALID, type=0)


class Flight:
    """What a log says about one vehicle; without an autopilot in it, `vehicle` is None."""

    def __init__(self, log: Log, system: int | None = None) -> None:
        self.log = log
        log.load(SUMMARY_MESSAGES)
        self.participants: list[Participant] = find_participants(log)
        self.autopilot: Participant | None = main_autopilot(self.participants, system)
        self.vehicle: LoggedVehicle | None = vehicle_of(self.autopilot)
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
    def other_vehicles(self) -> list[Participant]:
        """The autopilots of other systems in the log."""
        return [each for each in autopilots(self.participants) if each is not self.autopilot]

    @cached_property
    def restarts(self) -> list[int]:
        """When the autopilot had started again, by its own clock."""
        tables = (self.of_vehicle(name) for name in clocked_names(self.log.counts))
        clocked = next((table for table in tables if len(table)), None)
        return [] if clocked is None else restarts_of(clocked).tolist()

    @cached_property
    def states(self) -> States:
        """What the autopilot said of itself over time."""
        return find_states(self.log, self._who)

    @cached_property
    def modes(self) -> list[Interval]:
        """When the vehicle flew in which mode."""
        return mode_intervals(self.states, self._who, self.end_us)

    @cached_property
    def armed(self) -> list[Interval]:
        """When the vehicle was armed."""
        return armed_intervals(self.states, self.end_us)

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
        return failsafe_intervals(self.states, self.end_us)

    @cached_property
    def outing_kind(self) -> OutingKind:
        """What being under way is to this vehicle: a flight, a drive, a dive."""
        return kind_of(self.vehicle)

    @cached_property
    def outings(self) -> list[Interval]:
        """When the vehicle was under way, whatever it is."""
        told = map(self.of_vehicle, TELL_LANDED)
        states = next((table for table in told if len(table)), self.of_vehicle(TELL_LANDED[0]))
        return find_outings(self.outing_kind, self.motion, self.armed, states, self.end_us)

    @property
    def flying(self) -> list[Interval]:
        """When the vehicle was in the air; never, for what drives or dives."""
        return self.outings if self.outing_kind.noun == "flight" else []

    @property
    def ends_under_way(self) -> bool:
        """Whether the log ends while the vehicle flies, drives or dives."""
        return bool(self.outings) and self.outings[-1].is_open

    @property
    def ends_armed(self) -> bool:
        """Whether the log ends while the vehicle is armed."""
        return bool(self.armed) and self.armed[-1].is_open

    @cached_property
    def ending(self) -> str:
        """How the log ends: landed, on the ground, in the air, or unknown."""
        kind = self.outing_kind
        if not len(self.states):
            return "unknown: no heartbeat of an autopilot"
        if not self.states.tells_armed:
            return "unknown: nothing tells whether it was armed"
        if self.ends_under_way:
            return f"{kind.under_way}, {'armed' if self.ends_armed else 'disarmed'}"
        if self.ends_armed:
            return f"{kind.at_rest}, still armed"
        return f"{kind.done} and disarmed" if self.outings else kind.never

    @cached_property
    def battery(self) -> LoggedBattery:
        """Voltage and charge over time, from whichever message tells them."""
        return find_battery(self.log, self._who)

    @cached_property
    def gps(self) -> GpsQuality:
        """How well its GPS saw the sky."""
        return find_gps(self.log, self._who)

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
    def streams_setpoints(self) -> bool:
        """Whether someone in this log streams setpoints, rather than sends one now and then."""
        times = setpoint_times(self.log, self._who)
        return bool(np.count_nonzero(np.diff(times) < STREAM_STEP_US) >= MIN_STREAMED)

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
