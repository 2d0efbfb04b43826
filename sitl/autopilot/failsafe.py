"""What the vehicle does when it can't do what it was told: a pure table of conditions.

Each row of `ROWS` looks at the conditions and names an action or none; the first that does decides.
While the condition lasts the intention stays, so that a flight resumes when the cause is gone.
"""

from collections.abc import Callable
from enum import Enum
from typing import NamedTuple

from sitl.modes import Mode


class Action(Enum):
    """What a failsafe does; the values are the modes it leads to."""

    POSITION = Mode.POSCTL
    ALTITUDE = Mode.ALTCTL
    STABILIZED = Mode.STABILIZED
    RETURN = Mode.RTL
    LAND = Mode.LAND
    HOLD = Mode.HOLD
    TERMINATE = Mode.TERMINATION
    DISARM = None


class Conditions(NamedTuple):
    """What decides on a failsafe."""

    armed: bool
    intended: Mode
    offboard_available: bool
    offboard_loss_action: int  # COM_OBL_RC_ACT
    fence_breached: bool = False  # and the user has not taken over since
    fence_action: int = 0  # GF_ACTION


class Decision(NamedTuple):
    """The mode to fly, and whether it is a failsafe; no mode means to disarm at once."""

    mode: Mode | None
    failsafe: bool


# COM_OBL_RC_ACT. Without sticks the first three brake and descend, as PX4 does in Position.
OFFBOARD_LOSS_ACTIONS = (
    Action.POSITION,
    Action.ALTITUDE,
    Action.STABILIZED,
    Action.RETURN,
    Action.LAND,
    Action.HOLD,
    Action.TERMINATE,
    Action.DISARM,
)


def offboard_loss(conditions: Conditions) -> Action | None:
    """Act when the setpoint stream has stopped in OFFBOARD."""
    if conditions.intended is Mode.OFFBOARD and not conditions.offboard_available:
        return OFFBOARD_LOSS_ACTIONS[conditions.offboard_loss_action]
    return None


# GF_ACTION: none, a warning, hold, return, terminate, land.
FENCE_ACTIONS = (None, None, Action.HOLD, Action.RETURN, Action.TERMINATE, Action.LAND)


def geofence(conditions: Conditions) -> Action | None:
    """Act when the vehicle has left the fence."""
    return FENCE_ACTIONS[conditions.fence_action] if conditions.fence_breached else None


ROWS: tuple[Callable[[Conditions], Action | None], ...] = (geofence, offboard_loss)


def decide(conditions: Conditions) -> Decision:
    """Give the mode to fly: what was intended, or what the first failing row says."""
    if conditions.armed:
        for row in ROWS:
            action = row(conditions)
            if action is not None:
                return Decision(action.value, failsafe=True)
    return Decision(conditions.intended, failsafe=False)
