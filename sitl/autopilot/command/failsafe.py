"""What the vehicle does when it can't do what it was told: one pure table of inputs.

Each row of `ROWS` looks at the inputs and gives a trigger or none; of all triggers the gravest
action is taken. What happens over time is a pure function of a small memory:

    fine --trigger--> HOLD for COM_FAIL_ACT_T, if the trigger waits --> its action
    its action --condition gone--> fine; a trigger that stays waits for a new mode or disarming
    any --the user chooses a mode--> that mode, while the same causes last

The intention stays throughout, so that a flight resumes when the cause is gone.
"""

from collections.abc import Callable, Mapping
from enum import Enum
from typing import NamedTuple, Self

from sitl.autopilot.command.checks import BatteryLevel, Health, can_run, is_known, rules_of
from sitl.autopilot.command.mode_table import FLOWN, MODES, Action
from sitl.autopilot.parameters import ParameterValues
from sitl.clock import SECOND_US
from sitl.records.modes import Mode


class FailsafeCause(Enum):
    """Why; the values are what the pilot reads."""

    SETPOINTS = "No offboard setpoints"
    GROUND_STATION = "No connection to the ground control station"
    STICKS = "No manual control input"
    BATTERY = "Critical battery level"
    ESTIMATE = "No valid estimate"
    FENCE = "Geofence violated"
    MISSION = "Mission failure"


class FailsafeTrigger(NamedTuple):
    """One row's demand."""

    cause: FailsafeCause
    action: Action
    waits: bool = False  # holds for COM_FAIL_ACT_T first
    stays: bool = False  # until the user chooses a mode, though the condition may be gone
    yields: bool = False  # to the user, who may choose another mode


class FailsafeParameters(NamedTuple):
    """What to do, in PX4's numbers, and how long to hold first."""

    setpoint_loss: int = 0  # COM_OBL_RC_ACT
    ground_station_loss: int = 0  # NAV_DLL_ACT
    ground_station_exceptions: int = 0  # COM_DLL_EXCEPT
    sticks_loss: int = 2  # NAV_RCL_ACT
    sticks_exceptions: int = 0  # COM_RCL_EXCEPT
    low_battery: int = 3  # COM_LOW_BAT_ACT
    fence: int = 2  # GF_ACTION
    hold_us: int = 5_000_000  # COM_FAIL_ACT_T

    @classmethod
    def resolve(cls, values: ParameterValues) -> Self:
        """Take PX4's values."""
        return cls(
            setpoint_loss=int(values["COM_OBL_RC_ACT"]),
            ground_station_loss=int(values["NAV_DLL_ACT"]),
            ground_station_exceptions=int(values["COM_DLL_EXCEPT"]),
            sticks_loss=int(values["NAV_RCL_ACT"]),
            sticks_exceptions=int(values["COM_RCL_EXCEPT"]),
            low_battery=int(values["COM_LOW_BAT_ACT"]),
            fence=int(values["GF_ACTION"]),
            hold_us=round(values["COM_FAIL_ACT_T"] * SECOND_US),
        )


class FailsafeInputs(NamedTuple):
    """What decides on a failsafe."""

    armed: bool
    intended: Mode
    health: Health
    parameters: FailsafeParameters = FailsafeParameters()


class FailsafeMemory(NamedTuple):
    """What is kept from tick to tick."""

    since_us: int | None = None  # when a trigger first asked to wait
    kept: FailsafeTrigger | None = None  # one that stays
    overridden: frozenset[FailsafeCause] = frozenset()  # the user has chosen otherwise


class FailsafeDecision(NamedTuple):
    """The mode to fly (none: disarm at once), why it isn't the intended one, and what is next."""

    mode: Mode | None
    cause: FailsafeCause | None = None
    next_action: Action | None = None  # after the hold


# COM_OBL_RC_ACT. The first three are a pilot's, who has sticks: without, NAV_RCL_ACT goes.
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


def setpoint_loss(inputs: FailsafeInputs) -> FailsafeTrigger | None:
    """Act when the setpoint stream has stopped in OFFBOARD."""
    health, parameters = inputs.health, inputs.parameters
    if health.offboard_available or not MODES[inputs.intended].needs.setpoints:
        return None
    action = SETPOINT_LOSS_ACTIONS[parameters.setpoint_loss]
    if action <= Action.STABILIZED and not health.sticks_available:
        action = LINK_LOSS_ACTIONS.get(parameters.sticks_loss, Action.RETURN)
    return FailsafeTrigger(FailsafeCause.SETPOINTS, action)


def ground_station_loss(inputs: FailsafeInputs) -> FailsafeTrigger | None:
    """Act when a ground station that was there has been silent for COM_DL_LOSS_T."""
    parameters = inputs.parameters
    if not inputs.health.ground_station_lost:
        return None
    if MODES[inputs.intended].exception_bit & parameters.ground_station_exceptions:
        return None
    return _link_loss(FailsafeCause.GROUND_STATION, parameters.ground_station_loss)


def sticks_loss(inputs: FailsafeInputs) -> FailsafeTrigger | None:
    """Act when sticks that were there have been silent for COM_RC_LOSS_T."""
    parameters = inputs.parameters
    if not inputs.health.sticks_lost:
        return None
    if MODES[inputs.intended].exception_bit & parameters.sticks_exceptions:
        return None
    return _link_loss(FailsafeCause.STICKS, parameters.sticks_loss)


def battery(inputs: FailsafeInputs) -> FailsafeTrigger | None:
    """Act when the battery is nearly empty; a low one is only told of."""
    level, number = inputs.health.battery, inputs.parameters.low_battery
    if level < BatteryLevel.CRITICAL or number == 0:
        return None
    land = number == 2 or level is BatteryLevel.EMERGENCY
    wanted = Action.LAND if land else Action.RETURN
    return FailsafeTrigger(FailsafeCause.BATTERY, wanted, waits=True, stays=True, yields=True)


def estimate_loss(inputs: FailsafeInputs) -> FailsafeTrigger | None:
    """Act when the mode needs to know what the estimator no longer knows."""
    health = inputs.health
    if not health.attitude_valid:
        return FailsafeTrigger(FailsafeCause.ESTIMATE, Action.TERMINATE)
    rules = rules_of(inputs.intended, health)
    if is_known(rules.needs, health):
        return None
    action = next(a for a in rules.falls_back_to if can_run(FLOWN[a], health))
    return FailsafeTrigger(FailsafeCause.ESTIMATE, action)


def geofence(inputs: FailsafeInputs) -> FailsafeTrigger | None:
    """Act when the vehicle has left the fence, until the user takes over."""
    action = FENCE_ACTIONS[inputs.parameters.fence] if inputs.health.fence_breached else None
    return (
        None
        if action is None
        else FailsafeTrigger(
            FailsafeCause.FENCE,
            action,
            waits=action in (Action.RETURN, Action.LAND),
            stays=True,
            yields=True,
        )
    )


def mission_failure(inputs: FailsafeInputs) -> FailsafeTrigger | None:
    """Act when a mission that is flown can't go on."""
    if not (inputs.health.mission_failed and MODES[inputs.intended].needs.mission):
        return None
    return FailsafeTrigger(FailsafeCause.MISSION, Action.RETURN, waits=True, yields=True)


ROWS: tuple[Callable[[FailsafeInputs], FailsafeTrigger | None], ...] = (
    setpoint_loss,
    ground_station_loss,
    sticks_loss,
    battery,
    estimate_loss,
    geofence,
    mission_failure,
)


def decide(
    inputs: FailsafeInputs, memory: FailsafeMemory, time_us: int
) -> tuple[FailsafeDecision, FailsafeMemory]:
    """Give the mode to fly, and what to remember for the next tick."""
    intended = inputs.intended
    if not inputs.armed:
        return FailsafeDecision(intended), FailsafeMemory()
    found = [trigger for row in ROWS if (trigger := row(inputs)) is not None]
    overridden = memory.overridden
    if overridden:
        overridden &= {trigger.cause for trigger in found}
        found = [trigger for trigger in found if trigger.cause not in overridden]
    if memory.kept is not None:
        found.append(memory.kept)
    if not found:
        return FailsafeDecision(intended), FailsafeMemory(overridden=overridden)
    worst = max(found, key=lambda trigger: (trigger.action, not trigger.waits))
    since_us = time_us if memory.since_us is None else memory.since_us
    waits = worst.waits and worst.action > Action.HOLD and not MODES[intended].on_the_way_down
    if waits and time_us - since_us < inputs.parameters.hold_us:
        mode = _settle(Action.HOLD, inputs)
        return FailsafeDecision(mode, worst.cause, worst.action), FailsafeMemory(
            since_us, None, overridden
        )
    kept = worst if worst.stays else memory.kept
    return FailsafeDecision(_settle(worst.action, inputs), worst.cause), FailsafeMemory(
        since_us, kept, overridden
    )


def override(inputs: FailsafeInputs, memory: FailsafeMemory) -> FailsafeMemory:
    """Let the user's new mode go before every trigger that yields."""
    found = [trigger for row in ROWS if (trigger := row(inputs)) is not None]
    causes = {trigger.cause for trigger in found if trigger.yields}
    return FailsafeMemory(overridden=memory.overridden | causes)


def _link_loss(cause: FailsafeCause, number: int) -> FailsafeTrigger | None:
    action = LINK_LOSS_ACTIONS.get(number)
    if action is None:
        return None
    return FailsafeTrigger(cause, action, waits=True, stays=action is not Action.HOLD, yields=True)


def _settle(action: Action, inputs: FailsafeInputs) -> Mode | None:
    """Give the mode of an action, or of the next graver one that the estimate allows."""
    if MODES[inputs.intended].on_the_way_down and action in (Action.HOLD, Action.RETURN):
        return inputs.intended
    mode = FLOWN.get(action)
    while mode is not None and not is_known(MODES[mode].needs, inputs.health):
        mode = FLOWN[MODES[mode].falls_back_to[-1]]
    return mode
