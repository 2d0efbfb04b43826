"""Every transition of the mission, in tables; docs/mission.md draws them.

Rules:

1. TRANSITIONS says for each phase which events it heeds, and for each of them where it leads,
   what it requests of the vehicle, and how the flight has ended by it. An event that a phase does
   not list is none to it; of several at once, the one that is listed first counts.
2. A transition to a junction goes on by the junction's own table, JUNCTIONS: whether the vehicle
   stands on the ground, and whether the flight is to be landed at all.
3. A transition to another phase sends its request at once. One that stays sends it again after a
   while, until its effect shows in the vehicle's HEARTBEAT.
4. The first outcome stays. Only COMPLETED gives way to a later one, for a flight is not complete
   while the motors run, and every outcome gives way to LINK_LOST.
5. HELD_TOO_LONG ends the flight by the reason of its hold.

What we have lifted is landed; what we have not touched, or what somebody else steers, is left
alone. A vehicle that somebody takes out of a mode is not fought over.
"""

from enum import Enum
from typing import NamedTuple

from flightstack.companion.mission.records import MissionPhase, MissionRequest, Outcome


class MissionEvent(Enum):
    """What may happen to a mission; the words stand in its diagram."""

    VEHICLE_SILENT = "vehicle silent"
    VEHICLE_RESTARTED = "vehicle has restarted"
    OTHER_PILOT = "somebody else steers"
    STOP_REQUESTED = "stop requested"
    HELD_TOO_LONG = "held too long"
    HEARTBEAT_LOST = "heartbeat lost"
    PHASE_TOO_LONG = "takes too long"
    COURSE_OVER_BEFORE = "course over before"
    HOME_UNKNOWN = "home unknown"
    UNFIT_MODE = "mode unfit to arm in"
    ARMABLE = "can be armed"
    FOUND_ARMED = "found armed"
    ARMED_ON_GROUND = "armed on the ground"
    NOT_ARMED = "not armed"
    ARMED = "armed"
    DISARMED = "disarmed"
    STILL_ARMED = "still armed on the ground"
    HOVERING = "holds in the air"
    MODE_NOT_SEEN = "mode not seen"
    MODE_LOST = "other mode"
    HEARD_AGAIN = "heard again"
    OFFBOARD_SEEN = "OFFBOARD seen"
    COURSE_FINISHED = "course finished"
    COLLIDED = "collision"
    GATE_MISSED = "gate missed"
    GATE_OVERDUE = "gate overdue"
    TIME_UP = "duration over"
    TIME_UP_ON_COURSE = "duration over on the course"


class Junction(Enum):
    """Where a transition depends on how the vehicle stands."""

    CONCLUDE = "conclude"
    CALL = "call"
    YIELD = "yield"


class Stand(Enum):
    """How the vehicle stands at a junction; the words stand in the diagram."""

    ENDS_IN_AIR = "not to be landed"
    ON_GROUND = "on the ground"
    ALOFT = "in the air"


class Transition(NamedTuple):
    """Where an event leads, what is then requested, and how the flight has ended by it."""

    to: MissionPhase | Junction
    request: MissionRequest | None = None
    outcome: Outcome | None = None


P, E, R = MissionPhase, MissionEvent, MissionRequest
OURS = (  # to land
    P.ARMING,
    P.TAKING_OFF,
    P.ENTERING_OFFBOARD,
    P.FLYING,
    P.REACHING,
    P.LANDING,
)
OTHERS = Transition(P.DONE, None, Outcome.OTHER_PILOT)  # at once: each setpoint of ours disturbs
SILENT = {
    E.VEHICLE_SILENT: Transition(P.DONE, None, Outcome.LINK_LOST),
    E.VEHICLE_RESTARTED: Transition(P.DONE, None, Outcome.RESTARTED),
}
SILENT_OURS = {
    E.VEHICLE_SILENT: Transition(Junction.CALL, None, Outcome.LINK_LOST),
    E.VEHICLE_RESTARTED: Transition(Junction.CALL, None, Outcome.RESTARTED),
}
HAZARDS = SILENT_OURS | {
    E.OTHER_PILOT: OTHERS,
    E.STOP_REQUESTED: Transition(Junction.CONCLUDE, None, Outcome.INTERRUPTED),
    E.HELD_TOO_LONG: Transition(Junction.CONCLUDE),
    E.HEARTBEAT_LOST: Transition(Junction.CONCLUDE, None, Outcome.LINK_LOST),
}
REFUSED = Transition(Junction.CONCLUDE, None, Outcome.REFUSED)
LOST = Transition(Junction.YIELD, None, Outcome.TAKEN_OVER)

TRANSITIONS: dict[MissionPhase, dict[MissionEvent, Transition]] = {
    P.WAITING: {
        **SILENT,
        E.OTHER_PILOT: OTHERS,
        E.STOP_REQUESTED: Transition(P.DONE, None, Outcome.INTERRUPTED),
        E.HELD_TOO_LONG: Transition(P.DONE),
        E.HEARTBEAT_LOST: Transition(P.DONE, None, Outcome.LINK_LOST),
        E.PHASE_TOO_LONG: Transition(P.DONE, None, Outcome.REFUSED),
        E.COURSE_OVER_BEFORE: Transition(P.DONE, None, Outcome.COURSE_OVER),
        E.HOME_UNKNOWN: Transition(P.WAITING, R.HOME_POSITION),
        E.FOUND_ARMED: Transition(Junction.CONCLUDE, None, Outcome.FOUND_ARMED),
        E.ARMED_ON_GROUND: Transition(P.TAKING_OFF, R.TAKE_OFF),
        E.HOVERING: Transition(P.ENTERING_OFFBOARD, R.OFFBOARD_MODE),
        E.ARMABLE: Transition(P.ARMING, R.ARM),
        E.UNFIT_MODE: Transition(P.WAITING, R.HOLD_MODE),
    },
    P.ARMING: {
        **HAZARDS,
        E.PHASE_TOO_LONG: REFUSED,
        E.NOT_ARMED: Transition(P.ARMING, R.ARM),
        E.ARMED: Transition(P.TAKING_OFF, R.TAKE_OFF),
    },
    P.TAKING_OFF: {
        **HAZARDS,
        E.PHASE_TOO_LONG: REFUSED,
        E.DISARMED: REFUSED,
        E.MODE_NOT_SEEN: Transition(P.TAKING_OFF, R.TAKE_OFF),
        E.MODE_LOST: LOST,
        E.HOVERING: Transition(P.ENTERING_OFFBOARD, R.OFFBOARD_MODE),
    },
    P.ENTERING_OFFBOARD: {
        **HAZARDS,
        E.PHASE_TOO_LONG: REFUSED,
        E.DISARMED: LOST,
        E.MODE_LOST: LOST,
        E.MODE_NOT_SEEN: Transition(P.ENTERING_OFFBOARD, R.OFFBOARD_MODE),
        E.OFFBOARD_SEEN: Transition(P.FLYING),
    },
    P.FLYING: {
        **HAZARDS,
        E.COURSE_FINISHED: Transition(Junction.CONCLUDE, None, Outcome.COMPLETED),
        E.COLLIDED: Transition(Junction.CONCLUDE, None, Outcome.COLLISION),
        E.GATE_MISSED: Transition(Junction.CONCLUDE, None, Outcome.MISSED_GATE),
        E.DISARMED: LOST,
        E.MODE_LOST: LOST,
        E.TIME_UP: Transition(Junction.CONCLUDE, None, Outcome.COMPLETED),
        E.TIME_UP_ON_COURSE: Transition(Junction.CONCLUDE, None, Outcome.TIMEOUT),
        E.GATE_OVERDUE: Transition(Junction.CONCLUDE, None, Outcome.TIMEOUT),
    },
    P.TAKEN_OVER: {
        **SILENT,
        E.STOP_REQUESTED: Transition(P.DONE, None, Outcome.INTERRUPTED),
        E.DISARMED: Transition(P.DONE),
        E.TIME_UP: Transition(P.DONE),
        E.OFFBOARD_SEEN: Transition(P.LANDING, R.LAND),  # a failsafe has recovered: nobody steers
    },
    P.REACHING: {
        E.VEHICLE_RESTARTED: Transition(P.REACHING, R.LAND, Outcome.RESTARTED),
        E.PHASE_TOO_LONG: Transition(P.DONE),
        E.VEHICLE_SILENT: Transition(P.REACHING, R.LAND, Outcome.LINK_LOST),
        E.DISARMED: Transition(P.DONE),
        E.MODE_LOST: Transition(Junction.YIELD),
        E.HEARD_AGAIN: Transition(P.LANDING, R.LAND),
    },
    P.LANDING: {
        **SILENT_OURS,
        E.PHASE_TOO_LONG: Transition(P.DONE, None, Outcome.REFUSED),
        E.DISARMED: Transition(P.DONE),
        E.STILL_ARMED: Transition(P.LANDING, R.DISARM),
        E.MODE_NOT_SEEN: Transition(P.LANDING, R.LAND),
    },
    P.DONE: {},
}
JUNCTIONS: dict[Junction, dict[Stand, tuple[MissionPhase, MissionRequest | None]]] = {
    Junction.CONCLUDE: {
        Stand.ENDS_IN_AIR: (P.DONE, None),
        Stand.ON_GROUND: (P.LANDING, R.DISARM),
        Stand.ALOFT: (P.LANDING, R.LAND),
    },
    Junction.CALL: {
        Stand.ENDS_IN_AIR: (P.DONE, R.LAND),
        Stand.ON_GROUND: (P.REACHING, R.LAND),
        Stand.ALOFT: (P.REACHING, R.LAND),
    },
    Junction.YIELD: {
        Stand.ENDS_IN_AIR: (P.DONE, None),
        Stand.ON_GROUND: (P.TAKEN_OVER, None),
        Stand.ALOFT: (P.TAKEN_OVER, None),
    },
}
