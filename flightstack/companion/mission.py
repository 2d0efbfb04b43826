"""Decide what the companion does next: a state machine without socket, thread or clock.

    WAITING --ready--> ARMING --armed--> TAKING_OFF --holds in the air--> ENTERING_OFFBOARD
       |                  |                   |                                |
       |                  |                   |                       OFFBOARD in HEARTBEAT
       |                  |                   |                                v
       |                  +-- hazard, refusal, end of the course, duration -- FLYING
       |                                      |                                |
       |                                      v                     OFFBOARD was left
       |                                   LANDING <-- OFFBOARD again -- TAKEN_OVER
       |                                      |                                |
       +-- hazard or refusal --> DONE <-- disarmed ----------------------------+

A hazard is a request to stop (a signal), a camera that gives no images, or a vehicle whose
heartbeat has stopped. `advance` is called for each camera image, and at the same pace without
images when they have stopped. It answers with the requests to send: each is made again after
RETRY_US until its effect shows in the vehicle's HEARTBEAT, and given up after the phase's limit.
A vehicle that somebody else takes out of a mode is not fought over.
"""

import math
from collections.abc import Callable
from dataclasses import replace

from flightstack.companion.mission_state import (
    MissionState,
    Outcome,
    Phase,
    Request,
    Situation,
)
from flightstack.mavlink.telemetry import Course, CourseFailure, LandedState, Telemetry
from flightstack.px4_modes import Px4Mode

SECOND_US = 1_000_000
PRESTREAM_US = SECOND_US  # PX4 documents a second of setpoints before OFFBOARD
HOME_PERIOD_US = 2_500_000  # PX4 streams HOME_POSITION every 2 s
HOVER_M_S = 0.3
SETTLED_US = SECOND_US  # PX4's take-off ends in hold before the climb has come to rest
SETTLED_LATEST_US = 20 * SECOND_US  # a poor estimate may never read so slow
RETRY_US = 3 * SECOND_US  # HEARTBEAT shows an effect up to 1 s late
GROUNDED_US = 4 * SECOND_US  # PX4 disarms by itself COM_DISARM_LAND (2 s) after landing
CAMERA_LOST_US = 2_500_000  # 0.5 s until the vehicle is held, 2 s more
HEARTBEAT_LOST_US = 3 * SECOND_US
LIMITS_US = {
    Phase.WAITING: 180 * SECOND_US,  # a position estimate may take minutes outdoors
    Phase.ARMING: 20 * SECOND_US,
    Phase.TAKING_OFF: 60 * SECOND_US,
    Phase.ENTERING_OFFBOARD: 15 * SECOND_US,
    Phase.LANDING: 120 * SECOND_US,
}
Step = tuple[MissionState, tuple[Request, ...]]


def advance(state: MissionState, situation: Situation, now_us: int) -> Step:
    """Move on by what is known now; return the new state and what to ask of the vehicle."""
    if state.entered_us is None:
        state = replace(state, entered_us=now_us)
    hazard = _hazard(state, situation, now_us)
    if hazard is not None:
        return _end(state, hazard, situation.vehicle, now_us)
    if _in_phase_us(state, now_us) > LIMITS_US.get(state.phase, now_us + 1):
        return _give_up(state, situation.vehicle, now_us)
    return STEPS[state.phase](state, situation.vehicle, now_us)


def _waiting(state: MissionState, vehicle: Telemetry, now_us: int) -> Step:
    if vehicle.course.over:  # by an earlier flight: this vehicle's referee has no more to say
        return _end(state, Outcome.COURSE_OVER, vehicle, now_us)
    waited_us = _in_phase_us(state, now_us)
    if vehicle.home_altitude_amsl_m is None and waited_us >= HOME_PERIOD_US:
        return _ask(state, Request.HOME_POSITION, now_us)
    if vehicle.home_altitude_amsl_m is None or waited_us < PRESTREAM_US:
        return state, ()
    return (
        _begin_armed(state, vehicle, now_us) if vehicle.armed else _prepare(state, vehicle, now_us)
    )


def _prepare(state: MissionState, vehicle: Telemetry, now_us: int) -> Step:
    if vehicle.armable:
        return _enter(state, Phase.ARMING, now_us, Request.ARM)
    if vehicle.custom_mode in (Px4Mode.LOITER, Px4Mode.OFFBOARD):
        return state, ()
    return _ask(state, Request.HOLD_MODE, now_us)  # some modes cannot be armed in


def _begin_armed(state: MissionState, vehicle: Telemetry, now_us: int) -> Step:
    """Go on from where somebody has brought the vehicle: armed on the ground, or holding."""
    if vehicle.landed is LandedState.ON_GROUND:
        return _enter(state, Phase.TAKING_OFF, now_us, Request.TAKE_OFF)
    if vehicle.landed is LandedState.IN_AIR and vehicle.custom_mode == Px4Mode.LOITER:
        return _enter(state, Phase.ENTERING_OFFBOARD, now_us, Request.OFFBOARD_MODE)
    return state, ()


def _arming(state: MissionState, vehicle: Telemetry, now_us: int) -> Step:
    if vehicle.armed:
        return _enter(state, Phase.TAKING_OFF, now_us, Request.TAKE_OFF)
    return _ask(state, Request.ARM, now_us)


def _taking_off(state: MissionState, vehicle: Telemetry, now_us: int) -> Step:
    if not vehicle.armed:
        return _end(state, Outcome.REFUSED, vehicle, now_us)
    if vehicle.custom_mode == Px4Mode.TAKEOFF:
        return replace(state, confirmed=True), ()
    if not state.confirmed:
        return _ask(state, Request.TAKE_OFF, now_us)
    if vehicle.custom_mode != Px4Mode.LOITER:
        return _lose_control(state, now_us)
    state = _watch_speed(state, vehicle, now_us)
    settled = state.slow_us is not None and now_us - state.slow_us >= SETTLED_US
    if vehicle.landed is LandedState.IN_AIR and (
        settled or _in_phase_us(state, now_us) > SETTLED_LATEST_US
    ):
        return _enter(state, Phase.ENTERING_OFFBOARD, now_us, Request.OFFBOARD_MODE)
    return state, ()


def _watch_speed(state: MissionState, vehicle: Telemetry, now_us: int) -> MissionState:
    """Note since when the vehicle hovers."""
    speed_m_s = math.inf if vehicle.velocity_ned is None else math.hypot(*vehicle.velocity_ned)
    if speed_m_s >= HOVER_M_S:
        return replace(state, slow_us=None)
    return replace(state, slow_us=now_us) if state.slow_us is None else state


def _entering_offboard(state: MissionState, vehicle: Telemetry, now_us: int) -> Step:
    if not vehicle.armed:
        return _lose_control(state, now_us)
    if vehicle.custom_mode == Px4Mode.OFFBOARD:
        state, requests = _enter(state, Phase.FLYING, now_us)
        return replace(state, offboard_us=now_us), requests
    if vehicle.custom_mode != Px4Mode.LOITER:
        return _lose_control(state, now_us)
    return _ask(state, Request.OFFBOARD_MODE, now_us)


def _flying(state: MissionState, vehicle: Telemetry, now_us: int) -> Step:
    course = vehicle.course
    if course.over:
        return _end(state, _judgement(course), vehicle, now_us)
    if not vehicle.armed or vehicle.custom_mode != Px4Mode.OFFBOARD:
        return _lose_control(state, now_us)
    if _time_is_up(state, now_us):  # the end of a course that is still being flown, or of all
        outcome = Outcome.TIMEOUT if course.known else Outcome.COMPLETED
        return _end(state, outcome, vehicle, now_us)
    if course.gates_passed > state.gates_passed:
        state = replace(state, gates_passed=course.gates_passed, gate_us=now_us)
    if _is_lost(state, now_us):
        return _end(state, Outcome.TIMEOUT, vehicle, now_us)
    return state, ()


def _taken_over(state: MissionState, vehicle: Telemetry, now_us: int) -> Step:
    if not vehicle.armed or _time_is_up(state, now_us):
        return _enter(state, Phase.DONE, now_us)
    if vehicle.custom_mode == Px4Mode.OFFBOARD:  # a failsafe has recovered: nobody else steers
        return _enter(state, Phase.LANDING, now_us, Request.LAND)
    return state, ()


def _landing(state: MissionState, vehicle: Telemetry, now_us: int) -> Step:
    if not vehicle.armed and (vehicle.heartbeat_us or 0) > (state.entered_us or 0):
        return _enter(state, Phase.DONE, now_us)
    if vehicle.landed is LandedState.ON_GROUND:
        if now_us - vehicle.landed_us < GROUNDED_US:
            return state, ()
        return _ask(state, Request.DISARM, now_us)
    if vehicle.custom_mode == Px4Mode.LAND:
        return replace(state, confirmed=True), ()
    return (state, ()) if state.confirmed else _ask(state, Request.LAND, now_us)


STEPS: dict[Phase, Callable[[MissionState, Telemetry, int], Step]] = {
    Phase.WAITING: _waiting,
    Phase.ARMING: _arming,
    Phase.TAKING_OFF: _taking_off,
    Phase.ENTERING_OFFBOARD: _entering_offboard,
    Phase.FLYING: _flying,
    Phase.TAKEN_OVER: _taken_over,
    Phase.LANDING: _landing,
    Phase.DONE: lambda state, _vehicle, _now_us: (state, ()),
}


def _hazard(state: MissionState, situation: Situation, now_us: int) -> Outcome | None:
    if state.phase in (Phase.LANDING, Phase.DONE):
        return None
    if situation.stop_requested:
        return Outcome.INTERRUPTED
    if state.phase is Phase.TAKEN_OVER:
        return None
    if now_us - situation.image_us > CAMERA_LOST_US:
        return Outcome.CAMERA_LOST
    heartbeat_us = situation.vehicle.heartbeat_us
    if heartbeat_us is not None and now_us - heartbeat_us > HEARTBEAT_LOST_US:
        return Outcome.LINK_LOST
    return None


def _judgement(course: Course) -> Outcome:
    if course.finished:
        return Outcome.COMPLETED
    collided = course.failure is CourseFailure.COLLISION
    return Outcome.COLLISION if collided else Outcome.MISSED_GATE


def _in_phase_us(state: MissionState, now_us: int) -> int:
    return now_us - (now_us if state.entered_us is None else state.entered_us)


def _time_is_up(state: MissionState, now_us: int) -> bool:
    if state.duration_us is None or state.offboard_us is None:
        return False
    return now_us - state.offboard_us >= state.duration_us


def _is_lost(state: MissionState, now_us: int) -> bool:
    since_us = state.offboard_us if state.gate_us is None else state.gate_us
    if state.gate_timeout_us is None or since_us is None:
        return False
    return now_us - since_us >= state.gate_timeout_us


def _enter(state: MissionState, phase: Phase, now_us: int, *requests: Request) -> Step:
    requested_us = now_us if requests else None
    entered = replace(
        state, phase=phase, entered_us=now_us, requested_us=requested_us, confirmed=False
    )
    return entered, requests


def _ask(state: MissionState, request: Request, now_us: int) -> Step:
    if state.requested_us is not None and now_us - state.requested_us < RETRY_US:
        return state, ()
    return replace(state, requested_us=now_us), (request,)


def _end(state: MissionState, outcome: Outcome, vehicle: Telemetry, now_us: int) -> Step:
    """Land what we have lifted, and leave alone what we have not touched or no longer steer."""
    state = _conclude(state, outcome, now_us)
    if state.phase in (Phase.WAITING, Phase.TAKEN_OVER) or not state.lands:
        return _enter(state, Phase.DONE, now_us)
    on_ground = vehicle.landed is LandedState.ON_GROUND
    return _enter(state, Phase.LANDING, now_us, Request.DISARM if on_ground else Request.LAND)


def _lose_control(state: MissionState, now_us: int) -> Step:
    phase = Phase.TAKEN_OVER if state.lands else Phase.DONE
    return _enter(_conclude(state, Outcome.TAKEN_OVER, now_us), phase, now_us)


def _give_up(state: MissionState, vehicle: Telemetry, now_us: int) -> Step:
    if state.phase is not Phase.LANDING:
        return _end(state, Outcome.REFUSED, vehicle, now_us)
    if state.outcome is Outcome.COMPLETED:  # it is not done while the motors run
        state = replace(state, outcome=Outcome.REFUSED)
    return _enter(state, Phase.DONE, now_us)


def _conclude(state: MissionState, outcome: Outcome, now_us: int) -> MissionState:
    if state.outcome is not None:  # what ended the flight first stays the reason
        return state
    return replace(state, outcome=outcome, ended_us=now_us)
