import pytest

from sitl.autopilot.failsafe import Conditions, Decision, decide
from sitl.modes import Mode


def conditions(**changes) -> Conditions:
    usual = Conditions(
        armed=True, intended=Mode.OFFBOARD, offboard_available=True, offboard_loss_action=0
    )
    return usual._replace(**changes)


def test_does_what_was_intended_while_all_is_well():
    assert decide(conditions()) == Decision(Mode.OFFBOARD, failsafe=False)
    assert decide(conditions(intended=Mode.RTL)) == Decision(Mode.RTL, failsafe=False)


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
def test_loss_of_setpoints_leads_where_the_parameter_says(action, mode):
    lost = conditions(offboard_available=False, offboard_loss_action=action)
    assert decide(lost) == Decision(mode, failsafe=True)


@pytest.mark.parametrize("mode", [Mode.HOLD, Mode.LAND, Mode.TAKEOFF])
def test_loss_of_setpoints_matters_in_offboard_only(mode):
    lost = conditions(intended=mode, offboard_available=False)
    assert decide(lost) == Decision(mode, failsafe=False)


def test_nothing_fails_safe_while_disarmed():
    lost = conditions(armed=False, offboard_available=False)
    assert decide(lost) == Decision(Mode.OFFBOARD, failsafe=False)
