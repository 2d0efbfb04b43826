"""Walk the mission's table, by what is known now.

`advance` is called for each camera image, and at the same pace without images when they have
stopped. It answers with the requests to send.
"""

from dataclasses import replace

from flightstack.companion.mission.events import read, stand
from flightstack.companion.mission.hold import choose_hold
from flightstack.companion.mission.records import (
    MissionPhase,
    MissionRequest,
    MissionStatus,
    Outcome,
    Situation,
)
from flightstack.companion.mission.table import JUNCTIONS, TRANSITIONS, Junction, MissionEvent

RETRY_US = 3_000_000  # HEARTBEAT shows an effect up to 1 s late
Step = tuple[MissionStatus, tuple[MissionRequest, ...]]


def advance(status: MissionStatus, situation: Situation, now_us: int) -> Step:
    """Move on by what is known now; return the new status and what to request of the vehicle."""
    hold = choose_hold(situation, now_us)
    if status.entered_us is None or hold != status.hold:
        entered_us = now_us if status.entered_us is None else status.entered_us
        status = replace(status, entered_us=entered_us, hold=hold)
    if situation.restarted_us is not None:  # its clock has begun anew, and so do our waits
        status = replace(status, entered_us=now_us, requested_us=None)
    status, event = read(status, situation, now_us)
    if event is None:
        return status, ()
    to, request, outcome = TRANSITIONS[status.phase][event]
    if event is MissionEvent.HELD_TOO_LONG and hold is not None:
        outcome = hold.reason
    if isinstance(to, Junction):
        to, request = JUNCTIONS[to][stand(status, situation.vehicle)]
    ended_us = now_us if situation.restarted_us is None else situation.restarted_us
    status = _conclude(status, outcome, ended_us)
    requests = () if request is None else (request,)
    if to is not status.phase:
        return _enter(status, to, requests, now_us)
    if status.requested_us is not None and now_us - status.requested_us < RETRY_US:
        return status, ()
    return replace(status, requested_us=now_us), requests


def _enter(
    status: MissionStatus, phase: MissionPhase, requests: tuple[MissionRequest, ...], now_us: int
) -> Step:
    entered = replace(
        status,
        phase=phase,
        entered_us=now_us,
        requested_us=now_us if requests else None,
        confirmed=False,
        offboard_us=now_us if phase is MissionPhase.FLYING else status.offboard_us,
    )
    return entered, requests


def _conclude(status: MissionStatus, outcome: Outcome | None, now_us: int) -> MissionStatus:
    stays = status.outcome not in (None, Outcome.COMPLETED) and outcome is not Outcome.LINK_LOST
    if outcome is None or stays:
        return status
    ended_us = now_us if status.ended_us is None else status.ended_us
    return replace(status, outcome=outcome, ended_us=ended_us)
