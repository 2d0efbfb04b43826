"""Which of PX4's parameters a flight counts on: the table of docs/real-vehicle.md, to be judged."""

from collections.abc import Callable
from dataclasses import dataclass

Value = int | float
DATA_LINK_BIT = 4  # of COM_RCL_EXCEPT: OFFBOARD may go on without the transmitter


@dataclass(frozen=True, slots=True)
class Rule:
    """A parameter, what it should be in words, and whether a value is that."""

    name: str
    wanted: str
    fits: Callable[[Value], bool]


def _at_most(name: str, limit: float, unit: str) -> Rule:
    return Rule(name, f"{limit:g} {unit} or less", lambda value: 0.0 < value <= limit + 1e-6)


def _one_of(name: str, *allowed: int) -> Rule:
    return Rule(name, " or ".join(map(str, allowed)), lambda value: value in allowed)


def _set(name: str, words: str) -> Rule:
    return Rule(name, words, lambda value: value > 0.0)


RULES = (
    _at_most("COM_OF_LOSS_T", 1.0, "s"),
    _one_of("COM_OBL_RC_ACT", 5, 4),
    Rule("COM_RCL_EXCEPT", "bit 2 (4) not set", lambda value: not int(value) & DATA_LINK_BIT),
    _one_of("NAV_RCL_ACT", 3, 2),
    _at_most("COM_RC_LOSS_T", 0.5, "s"),
    _one_of("GF_ACTION", 5, 2),
    _set("GF_MAX_HOR_DIST", "the field's size"),
    _set("GF_MAX_VER_DIST", "the field's height"),
    _at_most("MPC_XY_VEL_MAX", 3.0, "m/s"),
    _at_most("MPC_Z_VEL_MAX_UP", 1.5, "m/s"),
    _at_most("MPC_Z_VEL_MAX_DN", 1.0, "m/s"),
    _at_most("MPC_TILTMAX_AIR", 25.0, "degrees"),
    _one_of("COM_LOW_BAT_ACT", 2, 3),
)
