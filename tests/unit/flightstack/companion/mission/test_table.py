"""The mission's tables leave nothing out, and what reads the world knows no other events."""

from dataclasses import replace

from hypothesis import given
from hypothesis import strategies as st

from flightstack.companion.mission.machine import advance
from flightstack.companion.mission.records import (
    Hold,
    MissionPhase,
    MissionStatus,
    Outcome,
    Situation,
)
from flightstack.companion.mission.table import (
    JUNCTIONS,
    OURS,
    TRANSITIONS,
    Junction,
    MissionEvent,
    Stand,
    Transition,
)
from flightstack.mavlink.telemetry import Course, CourseFailure, LandedState, Telemetry
from flightstack.px4_modes import Px4Mode

US = st.integers(0, 200_000_000)
COURSES = st.builds(
    Course,
    gates_passed=st.integers(0, 3),
    gates_total=st.sampled_from([None, 8]),
    finished=st.booleans(),
    failed=st.booleans(),
    failure=st.sampled_from([None, *CourseFailure]),
)
VEHICLES = st.builds(
    Telemetry,
    heartbeat_us=st.none() | US,
    custom_mode=st.sampled_from(Px4Mode),
    armed=st.booleans(),
    armable=st.booleans(),
    landed=st.sampled_from(LandedState),
    landed_us=US,
    home_altitude_amsl_m=st.sampled_from([None, 489.4]),
    velocity_ned=st.sampled_from([None, (0.0, 0.0, 0.0), (2.0, 0.0, 0.0)]),
    course=COURSES,
)
HOLDS = st.builds(Hold, reason=st.just(Outcome.COLLISION), since_us=US, lands_after_us=US)
SITUATIONS = st.builds(
    Situation,
    vehicle=VEHICLES,
    image_us=US,
    holds=st.tuples() | st.tuples(HOLDS, HOLDS),
    stop_requested=st.booleans(),
    vehicle_silent=st.booleans(),
    vehicle_gone=st.booleans(),
    restarted_us=st.none() | US,
    other_pilot=st.booleans(),
)
STATUSES = st.builds(
    MissionStatus,
    duration_us=st.none() | US,
    gate_timeout_us=st.none() | US,
    lands=st.booleans(),
    phase=st.sampled_from(MissionPhase),
    entered_us=st.none() | US,
    requested_us=st.none() | US,
    confirmed=st.booleans(),
    offboard_us=st.none() | US,
)


def leads_to(transition: Transition) -> set[MissionPhase]:
    if isinstance(transition.to, Junction):
        return {phase for phase, _ in JUNCTIONS[transition.to].values()}
    return {transition.to}


def test_every_phase_event_and_stand_is_in_the_tables() -> None:
    assert set(TRANSITIONS) == set(MissionPhase)
    assert {event for heeded in TRANSITIONS.values() for event in heeded} == set(MissionEvent)
    assert set(JUNCTIONS) == set(Junction)
    assert all(set(ways) == set(Stand) for ways in JUNCTIONS.values())


def test_every_phase_can_be_reached_and_ends() -> None:
    reached = {MissionPhase.WAITING}
    for _ in MissionPhase:
        reached |= {
            phase
            for begun in reached
            for transition in TRANSITIONS[begun].values()
            for phase in leads_to(transition)
        }
    assert reached == set(MissionPhase)
    assert not TRANSITIONS[MissionPhase.DONE]
    for phase in set(MissionPhase) - {MissionPhase.DONE}:
        ways = TRANSITIONS[phase].values()
        assert MissionPhase.DONE in set().union(*map(leads_to, ways)) or phase in OURS


def test_a_transition_that_stays_requests_something() -> None:
    for phase, heeded in TRANSITIONS.items():
        for transition in heeded.values():
            assert phase not in leads_to(transition) or transition.request is not None


def test_a_silent_vehicle_is_landed_where_we_have_lifted_it() -> None:
    landed = {
        phase
        for phase, heeded in TRANSITIONS.items()
        if MissionEvent.VEHICLE_SILENT in heeded
        and heeded[MissionEvent.VEHICLE_SILENT].to in (Junction.CALL, MissionPhase.REACHING)
    }
    assert landed == set(OURS)


@given(status=STATUSES, situation=SITUATIONS, now_us=US)
def test_whatever_is_seen_the_mission_goes_where_its_table_leads(
    status: MissionStatus, situation: Situation, now_us: int
) -> None:
    moved, requests = advance(status, situation, now_us)
    ways = TRANSITIONS[status.phase].values()
    assert moved.phase in {status.phase}.union(*map(leads_to, ways))
    assert len(requests) <= 1
    if moved.phase is not status.phase:
        assert moved.entered_us == now_us
        assert (moved.requested_us == now_us) == bool(requests)


@given(status=STATUSES, situation=SITUATIONS, now_us=US)
def test_what_ended_a_flight_first_stays(
    status: MissionStatus, situation: Situation, now_us: int
) -> None:
    ended = replace(status, outcome=Outcome.MISSED_GATE, ended_us=7)
    moved, _ = advance(ended, situation, now_us)
    assert moved.outcome in (Outcome.MISSED_GATE, Outcome.LINK_LOST)
    assert moved.ended_us == 7
