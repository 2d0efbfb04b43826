"""What the vehicle does when it can't do what it was told: one pure table of conditions.

Each row of `ROWS` looks at the conditions and gives a trigger or none; of all triggers the gravest
action is taken. What happens over time is a pure function of a small memory:

    fine --trigger--> HOLD for COM_FAIL_ACT_T, if the trigger waits --> its action
    its action --condition gone--> fine; a trigger that stays waits for a new mode or disarming
    any --the user chooses a mode--> that mode, while the same causes last

The intention stays throughout, so that a flight resumes when the cause is gone.
"""

from collections.abc import Callable, Mapping
from enum import Enum, IntEnum
from typing import NamedTuple

from sitl.autopilot.command.checks import NEEDS_POSITION, NEEDS_STICKS, Battery, Health
from sitl.records.modes import Mode


class Action(IntEnum):
    """What a failsafe does, the gravest last."""

    WARN = 0
    POSITION = 1
    ALTITUDE = 2
    STABILIZED = 3
    HOLD = 4
    RETURN = 5
    LAND = 6
    DISARM = 7
    TERMINATE = 8


MODES: Mapping[Action, Mode | None] = {
    Action.POSITION: Mode.POSCTL,
    Action.ALTITUDE: Mode.ALTCTL,
    Action.STABILIZED: Mode.STABILIZED,
    Action.HOLD: Mode.HOLD,
    Action.RETURN: Mode.RTL,
    Action.LAND: Mode.LAND,
    Action.DISARM: None,
    Action.TERMINATE: Mode.TERMINATION,
}
ON_THE_WAY_DOWN = {Mode.RTL, Mode.LAND, Mode.PRECLAND}


class Cause(Enum):
    """Why; the values are what the pilot reads."""

    SETPOINTS = "No offboard setpoints"
    GROUND_STATION = "No connection to the ground control station"
    STICKS = "No manual control input"
    BATTERY = "Critical battery level"
    ESTIMATE = "No valid estimate"
    FENCE = "Geofence violated"
    MISSION = "Mission failure"


class Trigger(NamedTuple):
    """One row's demand."""

    cause: Cause
    action: Action
    waits: bool = False  # holds for COM_FAIL_ACT_T first
    stays: bool = False  # until the user chooses a mode, though the condition may be gone
    yields: bool = False  # to the user, who may choose another mode


class Actions(NamedTuple):
    """The parameters that say what to do."""

    setpoint_loss: int = 0  # COM_OBL_RC_ACT
    ground_station_loss: int = 0  # NAV_DLL_ACT
    ground_station_exceptions: int = 0  # COM_DLL_EXCEPT
    sticks_loss: int = 2  # NAV_RCL_ACT
    sticks_exceptions: int = 0  # COM_RCL_EXCEPT
    low_battery: int = 3  # COM_LOW_BAT_ACT
    fence: int = 2  # GF_ACTION
    hold_us: int = 5_000_000  # COM_FAIL_ACT_T


class Conditions(NamedTuple):
    """What decides on a failsafe."""

    armed: bool
    intended: Mode
    health: Health
    actions: Actions = Actions()


class Memory(NamedTuple):
    """What is kept from tick to tick."""

    since_us: int | None = None  # when a trigger first asked to wait
    kept: Trigger | None = None  # one that stays
    overridden: frozenset[Cause] = frozenset()  # the user has chosen otherwise


class Decision(NamedTuple):
    """The mode to fly (none: disarm at once), why it isn't the intended one, and what is next."""

    mode: Mode | None
    cause: Cause | None = None
    next_action: Action | None = None  # after the hold


# COM_OBL_RC_ACT. Without sticks the first three brake and descend, as PX4 does in Position.
SETPOINT_LOSS_ACTIONS = (
    Action.POSITION,
    Action.ALTITUDE,
    Action.STABILIZED,
    Action.RETURN,
    Action.LAND,
    Action.HOLD,
    Action.TERMINATE,
    Action.DISARM,
)
# NAV_DLL_ACT and NAV_RCL_ACT; 0 does nothing, 4 means nothing any more.
LINK_LOSS_ACTIONS: Mapping[int, Action] = {
    1: Action.HOLD,
    2: Action.RETURN,
    3: Action.LAND,
    5: Action.TERMINATE,
    6: Action.DISARM,
}
# GF_ACTION: none, a warning, hold, return, terminate, land.
FENCE_ACTIONS = (None, None, Action.HOLD, Action.RETURN, Action.TERMINATE, Action.LAND)
EXCEPTION_BITS = {Mode.MISSION: 1, Mode.HOLD: 2, Mode.OFFBOARD: 4}  # COM_RCL_EXCEPT, COM_DLL_EXCEPT


def setpoint_loss(conditions: Conditions) -> Trigger | None:
    """Act when the setpoint stream has stopped in OFFBOARD."""
    if conditions.intended is not Mode.OFFBOARD or conditions.health.offboard_available:
        return None
    return Trigger(Cause.SETPOINTS, SETPOINT_LOSS_ACTIONS[conditions.actions.setpoint_loss])


def ground_station_loss(conditions: Conditions) -> Trigger | None:
    """Act when a ground station that was there has been silent for COM_DL_LOSS_T."""
    actions = conditions.actions
    if not conditions.health.ground_station_lost:
        return None
    if EXCEPTION_BITS.get(conditions.intended, 0) & actions.ground_station_exceptions:
        return None
    return _link_loss(Cause.GROUND_STATION, actions.ground_station_loss)


def sticks_loss(conditions: Conditions) -> Trigger | None:
    """Act when sticks that were there have been silent for COM_RC_LOSS_T."""
    actions = conditions.actions
    if not conditions.health.sticks_lost:
        return None
    if EXCEPTION_BITS.get(conditions.intended, 0) & actions.sticks_exceptions:
        return None
    return _link_loss(Cause.STICKS, actions.sticks_loss)


def battery(conditions: Conditions) -> Trigger | None:
    """Act when the battery is nearly empty; a low one is only told of."""
    level, action = conditions.health.battery, conditions.actions.low_battery
    if level < Battery.CRITICAL or action == 0:
        return None
    land = action == 2 or level is Battery.EMERGENCY
    wanted = Action.LAND if land else Action.RETURN
    return Trigger(Cause.BATTERY, wanted, waits=True, stays=True, yields=True)


def estimate_loss(conditions: Conditions) -> Trigger | None:
    """Act when the mode needs to know what the estimator no longer knows."""
    health, mode = conditions.health, conditions.intended
    if not health.attitude_valid:
        return Trigger(Cause.ESTIMATE, Action.TERMINATE)
    if mode is Mode.ALTCTL:
        return None if health.altitude_valid else Trigger(Cause.ESTIMATE, Action.LAND)
    if mode is Mode.POSCTL and health.altitude_valid and health.sticks_available:
        return None if health.position_valid else Trigger(Cause.ESTIMATE, Action.ALTITUDE)
    needs_position = mode in NEEDS_POSITION and not (
        mode is Mode.OFFBOARD and health.offboard_by_attitude
    )
    if needs_position and not (health.position_valid and health.altitude_valid):
        return Trigger(Cause.ESTIMATE, Action.LAND)
    return None


def geofence(conditions: Conditions) -> Trigger | None:
    """Act when the vehicle has left the fence, until the user takes over."""
    action = FENCE_ACTIONS[conditions.actions.fence] if conditions.health.fence_breached else None
    return None if action is None else Trigger(Cause.FENCE, action, stays=True, yields=True)


def mission_failure(conditions: Conditions) -> Trigger | None:
    """Act when a mission that is flown can't go on."""
    if conditions.intended is not Mode.MISSION or not conditions.health.mission_failed:
        return None
    return Trigger(Cause.MISSION, Action.RETURN, waits=True, yields=True)


ROWS: tuple[Callable[[Conditions], Trigger | None], ...] = (
    setpoint_loss,
    ground_station_loss,
    sticks_loss,
    battery,
    estimate_loss,
    geofence,
    mission_failure,
)


def decide(conditions: Conditions, memory: Memory, time_us: int) -> tuple[Decision, Memory]:
    """Give the mode to fly, and what to remember for the next tick."""
    intended = conditions.intended
    if not conditions.armed:
        return Decision(intended), Memory()
    found = [trigger for row in ROWS if (trigger := row(conditions)) is not None]
    overridden = memory.overridden
    if overridden:
        overridden &= {trigger.cause for trigger in found}
        found = [trigger for trigger in found if trigger.cause not in overridden]
    if memory.kept is not None:
        found.append(memory.kept)
    if not found:
        return Decision(intended), Memory(overridden=overridden)
    worst = max(found, key=lambda trigger: (trigger.action, not trigger.waits))
    since_us = time_us if memory.since_us is None else memory.since_us
    waits = worst.waits and worst.action > Action.HOLD and intended not in ON_THE_WAY_DOWN
    if waits and time_us - since_us < conditions.actions.hold_us:
        mode = _settle(Action.HOLD, conditions)
        return Decision(mode, worst.cause, worst.action), Memory(since_us, None, overridden)
    kept = worst if worst.stays else memory.kept
    return Decision(_settle(worst.action, conditions), worst.cause), Memory(
        since_us, kept, overridden
    )


def override(conditions: Conditions, memory: Memory) -> Memory:
    """Let the user's new mode go before every trigger that yields."""
    found = [trigger for row in ROWS if (trigger := row(conditions)) is not None]
    causes = {trigger.cause for trigger in found if trigger.yields}
    return Memory(overridden=memory.overridden | causes)


def _link_loss(cause: Cause, number: int) -> Trigger | None:
    action = LINK_LOSS_ACTIONS.get(number)
    if action is None:
        return None
    return Trigger(cause, action, waits=True, stays=action is not Action.HOLD, yields=True)


def _settle(action: Action, conditions: Conditions) -> Mode | None:
    """Give the mode of an action, or of the next graver one that the estimate allows."""
    health, intended = conditions.health, conditions.intended
    if intended in ON_THE_WAY_DOWN and action in (Action.HOLD, Action.RETURN):
        return intended  # a vehicle that comes home or down isn't kept from it
    located = health.attitude_valid and health.position_valid and health.altitude_valid
    mode = MODES[action]
    if not located and (action in (Action.HOLD, Action.RETURN) or mode is Mode.POSCTL):
        mode = Mode.LAND
    if mode in NEEDS_STICKS and not health.altitude_valid:
        mode = Mode.LAND
    if mode is Mode.LAND and not health.attitude_valid:
        mode = Mode.TERMINATION
    return mode
