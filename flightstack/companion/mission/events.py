"""Read the world as the one event that moves a mission on, or as none."""

import math
from collections.abc import Callable, Iterator
from dataclasses import replace

from flightstack.companion.mission.records import MissionPhase, MissionStatus, Situation
from flightstack.companion.mission.table import TRANSITIONS, MissionEvent, Stand
from flightstack.mavlink.telemetry import Course, CourseFailure, LandedState, Telemetry
from flightstack.px4_modes import Px4Mode

SECOND_US = 1_000_000
PRESTREAM_US = SECOND_US  # PX4 documents a second of setpoints before OFFBOARD
FOUND_US = 3 * SECOND_US  # by then whoever steers a vehicle that was armed before has been heard
HOME_PERIOD_US = 2_500_000  # PX4 streams HOME_POSITION every 2 s
HOVER_M_S = 0.3
SETTLED_US = SECOND_US  # PX4's take-off ends in hold before the climb has come to rest
SETTLED_LATEST_US = 20 * SECOND_US  # a poor estimate may never read so slow
GROUNDED_US = 4 * SECOND_US  # PX4 disarms by itself COM_DISARM_LAND (2 s) after landing
HEARTBEAT_LOST_US = 10 * SECOND_US  # while other messages come; PX4 COM_DL_LOSS_T
LIMITS_US = {
    MissionPhase.WAITING: 180 * SECOND_US,  # a position estimate may take minutes outdoors
    MissionPhase.ARMING: 20 * SECOND_US,
    MissionPhase.TAKING_OFF: 60 * SECOND_US,
    MissionPhase.ENTERING_OFFBOARD: 15 * SECOND_US,
    MissionPhase.LANDING: 120 * SECOND_US,
}
LEFT_BEHIND = (Px4Mode.TAKEOFF, Px4Mode.LOITER, Px4Mode.OFFBOARD, Px4Mode.LAND)  # by a companion
Reading = tuple[MissionStatus, MissionEvent | None]  # what is remembered, what has happened


def read(status: MissionStatus, situation: Situation, now_us: int) -> Reading:
    """Say what has happened, a hazard before all else."""
    heeded = TRANSITIONS[status.phase]
    for event in _hazards(status, situation, now_us):
        if event in heeded:
            return status, event
    return READERS[status.phase](status, situation.vehicle, now_us)


def stand(status: MissionStatus, vehicle: Telemetry) -> Stand:
    """Say what a junction depends on."""
    if not status.lands:
        return Stand.ENDS_IN_AIR
    return Stand.ON_GROUND if vehicle.landed is LandedState.ON_GROUND else Stand.ALOFT


def _hazards(status: MissionStatus, situation: Situation, now_us: int) -> Iterator[MissionEvent]:
    if situation.restarted_us is not None:
        yield MissionEvent.VEHICLE_RESTARTED
    if status.phase is MissionPhase.REACHING and (
        situation.vehicle_gone or _in_phase_us(status, now_us) > status.reach_us
    ):
        yield MissionEvent.PHASE_TOO_LONG
    if situation.vehicle_silent:
        yield MissionEvent.VEHICLE_SILENT
    if situation.other_pilot and not status.takes_over:
        yield MissionEvent.OTHER_PILOT
    if situation.stop_requested:
        yield MissionEvent.STOP_REQUESTED
    if status.hold is not None and now_us > status.hold.lands_us:
        yield MissionEvent.HELD_TOO_LONG
    heartbeat_us = situation.vehicle.heartbeat_us
    if heartbeat_us is not None and now_us - heartbeat_us > HEARTBEAT_LOST_US:
        yield MissionEvent.HEARTBEAT_LOST
    if _in_phase_us(status, now_us) > LIMITS_US.get(status.phase, now_us + 1):
        yield MissionEvent.PHASE_TOO_LONG


def _waiting(status: MissionStatus, vehicle: Telemetry, now_us: int) -> Reading:
    waited_us = _in_phase_us(status, now_us)
    if vehicle.course.over:  # by an earlier flight: this vehicle's referee has no more to say
        return status, MissionEvent.COURSE_OVER_BEFORE
    if vehicle.home_altitude_amsl_m is None:
        return status, MissionEvent.HOME_UNKNOWN if waited_us >= HOME_PERIOD_US else None
    if waited_us < PRESTREAM_US:
        return status, None
    if not vehicle.armed:
        return status, _prepare(vehicle)
    if status.takes_over:
        return status, _begin_armed(vehicle)
    return status, _found_armed(vehicle) if waited_us >= FOUND_US else None


def _prepare(vehicle: Telemetry) -> MissionEvent | None:
    if vehicle.armable:
        return MissionEvent.ARMABLE
    fit = vehicle.custom_mode in (Px4Mode.LOITER, Px4Mode.OFFBOARD)
    return None if fit else MissionEvent.UNFIT_MODE


def _found_armed(vehicle: Telemetry) -> MissionEvent | None:
    """Land or disarm what a flight before has left, but nothing that somebody else flies."""
    grounded = vehicle.landed is LandedState.ON_GROUND
    left = vehicle.landed is not LandedState.UNKNOWN and vehicle.custom_mode in LEFT_BEHIND
    return MissionEvent.FOUND_ARMED if grounded or left else None


def _begin_armed(vehicle: Telemetry) -> MissionEvent | None:
    """Go on from where somebody has brought the vehicle: armed on the ground, or holding."""
    if vehicle.landed is LandedState.ON_GROUND:
        return MissionEvent.ARMED_ON_GROUND
    if vehicle.landed is LandedState.IN_AIR and vehicle.custom_mode == Px4Mode.LOITER:
        return MissionEvent.HOVERING
    return None


def _arming(status: MissionStatus, vehicle: Telemetry, _now_us: int) -> Reading:
    return status, MissionEvent.ARMED if vehicle.armed else MissionEvent.NOT_ARMED


def _taking_off(status: MissionStatus, vehicle: Telemetry, now_us: int) -> Reading:
    if not vehicle.armed:
        return status, MissionEvent.DISARMED
    if vehicle.custom_mode == Px4Mode.TAKEOFF:
        return replace(status, confirmed=True), None
    if not status.confirmed:
        return status, MissionEvent.MODE_NOT_SEEN
    if vehicle.custom_mode != Px4Mode.LOITER:
        return status, MissionEvent.MODE_LOST
    status = _watch_speed(status, vehicle, now_us)
    settled = status.slow_us is not None and now_us - status.slow_us >= SETTLED_US
    if vehicle.landed is LandedState.IN_AIR and (
        settled or _in_phase_us(status, now_us) > SETTLED_LATEST_US
    ):
        return status, MissionEvent.HOVERING
    return status, None


def _watch_speed(status: MissionStatus, vehicle: Telemetry, now_us: int) -> MissionStatus:
    """Note since when the vehicle hovers."""
    speed_m_s = math.inf if vehicle.velocity_ned is None else math.hypot(*vehicle.velocity_ned)
    if speed_m_s >= HOVER_M_S:
        return replace(status, slow_us=None)
    return replace(status, slow_us=now_us) if status.slow_us is None else status


def _entering_offboard(status: MissionStatus, vehicle: Telemetry, _now_us: int) -> Reading:
    if not vehicle.armed:
        return status, MissionEvent.DISARMED
    if vehicle.custom_mode == Px4Mode.OFFBOARD:
        return status, MissionEvent.OFFBOARD_SEEN
    holding = vehicle.custom_mode == Px4Mode.LOITER
    return status, MissionEvent.MODE_NOT_SEEN if holding else MissionEvent.MODE_LOST


def _flying(status: MissionStatus, vehicle: Telemetry, now_us: int) -> Reading:
    course = vehicle.course
    if course.over:
        return status, _judgement(course)
    if not vehicle.armed:
        return status, MissionEvent.DISARMED
    if vehicle.custom_mode != Px4Mode.OFFBOARD:
        return status, MissionEvent.MODE_LOST
    if _time_is_up(status, now_us):  # the end of a course that is still being flown, or of all
        return status, MissionEvent.TIME_UP_ON_COURSE if course.known else MissionEvent.TIME_UP
    if course.gates_passed > status.gates_passed:
        status = replace(status, gates_passed=course.gates_passed, gate_us=now_us)
    return status, MissionEvent.GATE_OVERDUE if _gate_is_overdue(status, now_us) else None


def _taken_over(status: MissionStatus, vehicle: Telemetry, now_us: int) -> Reading:
    if not vehicle.armed:
        return status, MissionEvent.DISARMED
    if _time_is_up(status, now_us):
        return status, MissionEvent.TIME_UP
    back = vehicle.custom_mode == Px4Mode.OFFBOARD
    return status, MissionEvent.OFFBOARD_SEEN if back else None


def _reaching(status: MissionStatus, vehicle: Telemetry, _now_us: int) -> Reading:
    if vehicle.heartbeat_us is None:  # since it fell silent, or restarted
        return status, None
    if not vehicle.armed:
        return status, MissionEvent.DISARMED
    ours = vehicle.custom_mode in LEFT_BEHIND
    return status, MissionEvent.HEARD_AGAIN if ours else MissionEvent.MODE_LOST


def _landing(status: MissionStatus, vehicle: Telemetry, now_us: int) -> Reading:
    if not vehicle.armed and (vehicle.heartbeat_us or 0) > (status.entered_us or 0):
        return status, MissionEvent.DISARMED
    if vehicle.landed is LandedState.ON_GROUND:
        grounded = now_us - vehicle.landed_us >= GROUNDED_US
        return status, MissionEvent.STILL_ARMED if grounded else None
    if vehicle.custom_mode == Px4Mode.LAND:
        return replace(status, confirmed=True), None
    return status, None if status.confirmed else MissionEvent.MODE_NOT_SEEN


READERS: dict[MissionPhase, Callable[[MissionStatus, Telemetry, int], Reading]] = {
    MissionPhase.WAITING: _waiting,
    MissionPhase.ARMING: _arming,
    MissionPhase.TAKING_OFF: _taking_off,
    MissionPhase.ENTERING_OFFBOARD: _entering_offboard,
    MissionPhase.FLYING: _flying,
    MissionPhase.TAKEN_OVER: _taken_over,
    MissionPhase.REACHING: _reaching,
    MissionPhase.LANDING: _landing,
    MissionPhase.DONE: lambda status, _vehicle, _now_us: (status, None),
}


def _judgement(course: Course) -> MissionEvent:
    if course.finished:
        return MissionEvent.COURSE_FINISHED
    collided = course.failure is CourseFailure.COLLISION
    return MissionEvent.COLLIDED if collided else MissionEvent.GATE_MISSED


def _in_phase_us(status: MissionStatus, now_us: int) -> int:
    return now_us - (now_us if status.entered_us is None else status.entered_us)


def _time_is_up(status: MissionStatus, now_us: int) -> bool:
    if status.duration_us is None or status.offboard_us is None:
        return False
    return now_us - status.offboard_us >= status.duration_us


def _gate_is_overdue(status: MissionStatus, now_us: int) -> bool:
    since_us = status.offboard_us if status.gate_us is None else status.gate_us
    if status.gate_timeout_us is None or since_us is None:
        return False
    return now_us - since_us >= status.gate_timeout_us
