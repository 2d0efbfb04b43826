"""Every row of the failsafe table, and what happens over time."""

from collections.abc import Callable
from typing import Any

import pytest

from sitl.autopilot.command.checks import BatteryLevel, Health
from sitl.autopilot.command.failsafe import (
    ROWS,
    FailsafeCause,
    FailsafeDecision,
    FailsafeInputs,
    FailsafeMemory,
    FailsafeParameters,
    battery,
    decide,
    estimate_loss,
    geofence,
    ground_station_loss,
    override,
    setpoint_loss,
    sticks_loss,
)
from sitl.autopilot.command.mode_table import Action
from sitl.records.modes import Mode

WELL = Health(
    attitude_valid=True,
    position_valid=True,
    altitude_valid=True,
    offboard_available=True,
    sticks_available=True,
)
HOLD_US = 5_000_000
LINK_LOSS = [
    (1, Action.HOLD, False),
    (2, Action.RETURN, True),
    (3, Action.LAND, True),
    (5, Action.TERMINATE, True),
    (6, Action.DISARM, True),
]


def inputs(intended: Mode = Mode.OFFBOARD, *, armed: bool = True, **changes: Any) -> FailsafeInputs:
    parameters = {name: changes.pop(name) for name in FailsafeParameters._fields if name in changes}
    return FailsafeInputs(
        armed, intended, WELL._replace(**changes), FailsafeParameters(**parameters)
    )


def at_once(given: FailsafeInputs) -> FailsafeDecision:
    return decide(given, FailsafeMemory(), 0)[0]


def after(given: FailsafeInputs, elapsed_us: int) -> FailsafeDecision:
    _, memory = decide(given, FailsafeMemory(), 1000)
    return decide(given, memory, 1000 + elapsed_us)[0]


@pytest.mark.parametrize("mode", [Mode.OFFBOARD, Mode.RTL, Mode.HOLD, Mode.POSCTL, Mode.LAND])
def test_does_what_was_intended_while_all_is_well(mode: Mode) -> None:
    assert at_once(inputs(mode)) == FailsafeDecision(mode)
    assert not any(row(inputs(mode)) for row in ROWS)


@pytest.mark.parametrize(
    ("action", "mode"),
    [
        (0, Mode.POSCTL),
        (1, Mode.ALTCTL),
        (2, Mode.STABILIZED),
        (3, Mode.RTL),
        (4, Mode.LAND),
        (5, Mode.HOLD),
        (6, Mode.TERMINATION),
        (7, None),
    ],
)
def test_loss_of_setpoints_leads_at_once_where_the_parameter_says(
    action: int, mode: Mode | None
) -> None:
    lost = inputs(offboard_available=False, setpoint_loss=action)
    assert at_once(lost) == FailsafeDecision(mode, FailsafeCause.SETPOINTS)


@pytest.mark.parametrize("mode", [Mode.HOLD, Mode.LAND, Mode.TAKEOFF])
def test_loss_of_setpoints_matters_in_offboard_only(mode: Mode) -> None:
    assert setpoint_loss(inputs(mode, offboard_available=False)) is None


@pytest.mark.parametrize(("number", "action", "stays"), LINK_LOSS)
@pytest.mark.parametrize(
    ("row", "cause", "flag", "parameter"),
    [
        (
            ground_station_loss,
            FailsafeCause.GROUND_STATION,
            "ground_station_lost",
            "ground_station_loss",
        ),
        (sticks_loss, FailsafeCause.STICKS, "sticks_lost", "sticks_loss"),
    ],
)
def test_loss_of_a_link_does_what_the_parameter_says(
    row: Callable[..., Any],
    cause: FailsafeCause,
    flag: str,
    parameter: str,
    number: int,
    action: Action,
    *,
    stays: bool,
) -> None:
    lost: dict[str, Any] = {flag: True, parameter: number}
    trigger = row(inputs(**lost))
    assert trigger == (cause, action, True, stays, True)
    assert row(inputs(**lost | {flag: False})) is None


@pytest.mark.parametrize("number", [0, 4])
def test_loss_of_the_ground_station_may_mean_nothing(number: int) -> None:
    assert ground_station_loss(inputs(ground_station_lost=True)) is None
    lost = inputs(ground_station_lost=True, ground_station_loss=number)
    assert ground_station_loss(lost) is None


@pytest.mark.parametrize(
    ("mode", "bit"), [(Mode.MISSION, 1), (Mode.HOLD, 2), (Mode.OFFBOARD, 4), (Mode.POSCTL, 0)]
)
def test_a_mode_can_be_excepted_from_the_loss_of_a_link(mode: Mode, bit: int) -> None:
    for excepted in range(8):
        sticks = inputs(mode, sticks_lost=True, sticks_exceptions=excepted)
        station = inputs(
            mode,
            ground_station_lost=True,
            ground_station_loss=2,
            ground_station_exceptions=excepted,
        )
        assert (sticks_loss(sticks) is None) is bool(bit & excepted)
        assert (ground_station_loss(station) is None) is bool(bit & excepted)


@pytest.mark.parametrize(
    ("level", "parameter", "action"),
    [
        (BatteryLevel.FINE, 3, None),
        (BatteryLevel.LOW, 3, None),
        (BatteryLevel.CRITICAL, 3, Action.RETURN),
        (BatteryLevel.EMERGENCY, 3, Action.LAND),
        (BatteryLevel.CRITICAL, 2, Action.LAND),
        (BatteryLevel.EMERGENCY, 2, Action.LAND),
        (BatteryLevel.EMERGENCY, 0, None),
    ],
)
def test_an_empty_battery_brings_the_vehicle_down(
    level: BatteryLevel, parameter: int, action: Action | None
) -> None:
    trigger = battery(inputs(battery=level, low_battery=parameter))
    assert (trigger and trigger.action) == action


@pytest.mark.parametrize(
    ("number", "action"),
    [
        (0, None),
        (1, None),
        (2, Action.HOLD),
        (3, Action.RETURN),
        (4, Action.TERMINATE),
        (5, Action.LAND),
    ],
)
def test_leaving_the_fence_does_what_the_parameter_says(number: int, action: Action | None) -> None:
    trigger = geofence(inputs(fence_breached=True, fence=number))
    assert (trigger and trigger.action) == action
    is_held_first = action in (Action.RETURN, Action.LAND)
    assert trigger is None or trigger.waits == is_held_first
    assert geofence(inputs(fence=number)) is None


def test_a_mission_that_failed_leads_home_while_it_is_flown() -> None:
    failed = inputs(Mode.MISSION, mission_failed=True)
    assert at_once(failed) == FailsafeDecision(Mode.HOLD, FailsafeCause.MISSION, Action.RETURN)
    assert after(failed, HOLD_US) == FailsafeDecision(Mode.RTL, FailsafeCause.MISSION)
    assert at_once(inputs(Mode.HOLD, mission_failed=True)) == FailsafeDecision(Mode.HOLD)


@pytest.mark.parametrize(
    ("mode", "lost", "action"),
    [
        (Mode.HOLD, "attitude_valid", Action.TERMINATE),
        (Mode.LAND, "attitude_valid", Action.TERMINATE),
        (Mode.HOLD, "position_valid", Action.LAND),
        (Mode.OFFBOARD, "position_valid", Action.LAND),
        (Mode.OFFBOARD, "altitude_valid", Action.LAND),
        (Mode.LAND, "position_valid", None),
        (Mode.POSCTL, "position_valid", Action.ALTITUDE),
        (Mode.POSCTL, "altitude_valid", Action.LAND),
        (Mode.ALTCTL, "position_valid", None),
        (Mode.ALTCTL, "altitude_valid", Action.LAND),
    ],
)
def test_a_mode_ends_where_the_estimate_no_longer_carries_it(
    mode: Mode, lost: str, action: Action | None
) -> None:
    trigger = estimate_loss(inputs(mode, **{lost: False}))
    assert (trigger and trigger.action) == action


def test_attitude_setpoints_need_no_position() -> None:
    given = inputs(position_valid=False, altitude_valid=False, offboard_by_attitude=True)
    assert estimate_loss(given) is None


def test_return_waits_in_hold_for_the_delay() -> None:
    lost = inputs(Mode.OFFBOARD, ground_station_lost=True, ground_station_loss=2)
    assert at_once(lost) == FailsafeDecision(Mode.HOLD, FailsafeCause.GROUND_STATION, Action.RETURN)
    assert after(lost, HOLD_US - 4000).mode is Mode.HOLD
    assert after(lost, HOLD_US) == FailsafeDecision(Mode.RTL, FailsafeCause.GROUND_STATION)


def test_without_a_delay_nothing_waits() -> None:
    lost = inputs(sticks_lost=True, hold_us=0)
    assert at_once(lost) == FailsafeDecision(Mode.RTL, FailsafeCause.STICKS)


def test_what_comes_back_during_the_hold_is_as_if_nothing_had_been() -> None:
    lost = inputs(Mode.OFFBOARD, sticks_lost=True)
    _, memory = decide(lost, FailsafeMemory(), 0)
    decision, memory = decide(inputs(), memory, HOLD_US - 4000)
    assert (decision, memory) == (FailsafeDecision(Mode.OFFBOARD), FailsafeMemory())


def test_a_return_goes_on_though_the_link_is_back() -> None:
    lost = inputs(Mode.OFFBOARD, sticks_lost=True, hold_us=0)
    _, memory = decide(lost, FailsafeMemory(), 0)
    assert decide(inputs(hold_us=0), memory, 4000)[0] == FailsafeDecision(
        Mode.RTL, FailsafeCause.STICKS
    )


def test_a_hold_ends_when_the_link_is_back() -> None:
    lost = inputs(ground_station_lost=True, ground_station_loss=1)
    decision, memory = decide(lost, FailsafeMemory(), 0)
    assert decision == FailsafeDecision(Mode.HOLD, FailsafeCause.GROUND_STATION)
    assert decide(inputs(), memory, 4000)[0] == FailsafeDecision(Mode.OFFBOARD)


def test_the_user_goes_before_a_link_or_the_battery_but_not_before_the_estimate() -> None:
    lost = inputs(Mode.HOLD, battery=BatteryLevel.CRITICAL, sticks_lost=True, hold_us=0)
    _, memory = decide(lost, FailsafeMemory(), 0)
    memory = override(lost, memory)
    decision, memory = decide(lost, memory, 4000)
    assert decision == FailsafeDecision(Mode.HOLD)
    blind = lost._replace(health=lost.health._replace(position_valid=False))
    assert decide(blind, override(blind, memory), 8000)[0].mode is Mode.LAND


def test_an_overridden_cause_acts_again_once_it_has_been_gone() -> None:
    lost = inputs(Mode.HOLD, sticks_lost=True, hold_us=0)
    memory = override(lost, FailsafeMemory())
    _, memory = decide(inputs(Mode.HOLD), memory, 4000)
    assert decide(lost, memory, 8000)[0].mode is Mode.RTL


def test_the_gravest_action_is_taken() -> None:
    both = inputs(
        Mode.OFFBOARD, offboard_available=False, battery=BatteryLevel.EMERGENCY, hold_us=0
    )
    assert at_once(both) == FailsafeDecision(Mode.LAND, FailsafeCause.BATTERY)


def test_of_equally_grave_actions_the_one_that_does_not_wait_is_taken() -> None:
    both = inputs(sticks_lost=True, sticks_loss=3, offboard_available=False, setpoint_loss=4)
    assert at_once(both) == FailsafeDecision(Mode.LAND, FailsafeCause.SETPOINTS)


@pytest.mark.parametrize("mode", [Mode.RTL, Mode.LAND])
def test_a_vehicle_on_its_way_down_is_not_kept_from_it(mode: Mode) -> None:
    assert at_once(inputs(mode, sticks_lost=True)).mode is mode
    station = inputs(mode, ground_station_lost=True, ground_station_loss=1)
    assert at_once(station).mode is mode


def test_what_the_estimate_does_not_allow_falls_through() -> None:
    blind = inputs(Mode.ALTCTL, position_valid=False, sticks_lost=True, hold_us=0)
    assert at_once(blind).mode is Mode.LAND
    upset = blind._replace(health=blind.health._replace(attitude_valid=False))
    assert at_once(upset).mode is Mode.TERMINATION


def test_nothing_fails_safe_while_disarmed() -> None:
    lost = inputs(armed=False, offboard_available=False, battery=BatteryLevel.EMERGENCY)
    assert decide(lost, FailsafeMemory(since_us=1), 0) == (
        FailsafeDecision(Mode.OFFBOARD),
        FailsafeMemory(),
    )
