"""The table of modes is whole, and what it leads to ends."""

from typing import Any

import pytest

from sitl.autopilot.command.checks import Health, can_arm, can_run
from sitl.autopilot.command.mode_table import FLOWN, MODES, Acceptance, Action, Leader
from sitl.records.modes import Mode

ALL_WELL = Health(
    attitude_valid=True,
    position_valid=True,
    altitude_valid=True,
    offboard_available=True,
    sticks_available=True,
    mission_available=True,
)


def test_every_mode_has_a_row_and_a_name_of_its_own() -> None:
    assert set(MODES) == set(Mode)
    assert len({rules.name for rules in MODES.values()}) == len(Mode)


def test_every_action_but_disarming_has_a_mode() -> None:
    assert set(Action) - set(FLOWN) == {Action.DISARM}


@pytest.mark.parametrize("mode", Mode, ids=lambda mode: mode.name)
def test_what_needs_the_estimate_falls_back_until_nothing_is_needed(mode: Mode) -> None:
    seen = []
    while any(MODES[mode].needs[:3]):
        assert mode not in seen
        seen.append(mode)
        mode = FLOWN[MODES[mode].falls_back_to[-1]]
    assert not seen or mode is Mode.TERMINATION


@pytest.mark.parametrize("mode", Mode, ids=lambda mode: mode.name)
def test_a_mode_that_may_be_chosen_needs_what_its_row_says(mode: Mode) -> None:
    rules = MODES[mode]
    assert can_run(mode, ALL_WELL) is (rules.accepted is not Acceptance.NEVER)
    assert can_arm(mode, ALL_WELL) is rules.armable
    for name, needed in zip(ALL_WELL._fields[:3], rules.needs, strict=False):
        missing: dict[str, Any] = {name: False}
        lacks = ALL_WELL._replace(**missing)
        if rules.accepted is Acceptance.WITH_ITS_NEEDS:
            assert can_run(mode, lacks) is not needed


def test_only_a_termination_is_final_and_led_by_nobody() -> None:
    final = [mode for mode, rules in MODES.items() if rules.is_final]
    led_by_nobody = [mode for mode, rules in MODES.items() if rules.leader is Leader.NOBODY]
    assert final == led_by_nobody == [Mode.TERMINATION]
