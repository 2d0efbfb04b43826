"""Every flight mode in one table: who leads it, what it needs, allows and falls back to.

The rules by which the rows are read:

- A mode that is chosen in flight is refused while it lacks what it needs. `accepted` has the modes
  that are never flown by choice, and the landing, which nothing keeps from being one.
- Disarmed, any mode may be chosen, but a termination. The vehicle arms in those that are armable,
  while they could also be flown.
- When the estimate loses what the intended mode needs, the first of its fallbacks that can be flown
  is. Nothing flies without an attitude: that terminates the flight.
- A failsafe's own mode that can't be flown by the estimate gives way to the last of its fallbacks,
  and that one likewise.
- A vehicle on its way down is not kept from it by a failsafe that would hold or return.
- A termination is final: no mode follows it, until the next boot.
"""

from collections.abc import Mapping
from enum import Enum, IntEnum
from typing import NamedTuple

from sitl.records.modes import Mode


class Action(IntEnum):
    """What a failsafe does, the gravest last."""

    POSITION = 1
    ALTITUDE = 2
    STABILIZED = 3
    HOLD = 4
    RETURN = 5
    LAND = 6
    DISARM = 7
    TERMINATE = 8


class Leader(Enum):
    """Who says where to fly; without sticks, their modes are led by the navigator."""

    STREAM = "offboard setpoints"
    STICKS = "sticks"
    MISSION = "mission"  # by way of the navigator
    NAVIGATOR = "navigator"
    NOBODY = "nobody"


class Acceptance(Enum):
    """Whether a mode may be chosen in flight."""

    WITH_ITS_NEEDS = "with what it needs"
    ALWAYS = "always"
    NEVER = "never"


class Needs(NamedTuple):
    """What a mode can't do without: first of the estimate, then of others."""

    attitude: bool = False
    position: bool = False
    altitude: bool = False
    setpoints: bool = False
    sticks: bool = False
    mission: bool = False


class ModeRules(NamedTuple):
    """One row."""

    name: str  # as texts have it
    leader: Leader
    needs: Needs = Needs()
    accepted: Acceptance = Acceptance.WITH_ITS_NEEDS
    armable: bool = False
    falls_back_to: tuple[Action, ...] = ()
    takes_off: bool = False  # from the ground, by itself, at MPC_TKO_SPEED
    on_the_way_down: bool = False
    landed_state_in_air: int = 2  # MAV_LANDED_STATE: 2 in the air, 3 taking off, 4 landing
    exception_bit: int = 0  # of COM_RCL_EXCEPT and COM_DLL_EXCEPT: a lost link does nothing
    override_bit: int = 0  # of COM_RC_OVERRIDE: moved sticks take over
    is_final: bool = False  # the rotors stop, and no other mode follows


WHERE_IT_IS = Needs(attitude=True, position=True, altitude=True)
STREAM, STICKS, NAVIGATOR = Leader.STREAM, Leader.STICKS, Leader.NAVIGATOR
NEVER, LAND, TERMINATE = Acceptance.NEVER, (Action.LAND,), (Action.TERMINATE,)
IN_AUTO, IN_OFFBOARD = 1, 2  # bits of COM_RC_OVERRIDE

MODES: Mapping[Mode, ModeRules] = {
    Mode.MANUAL: ModeRules("Manual", NAVIGATOR, accepted=NEVER),
    Mode.ALTCTL: ModeRules(
        "Altitude",
        STICKS,
        Needs(attitude=True, altitude=True, sticks=True),
        armable=True,
        falls_back_to=LAND,
    ),
    Mode.POSCTL: ModeRules(
        "Position",
        STICKS,
        WHERE_IT_IS._replace(sticks=True),
        armable=True,
        falls_back_to=(Action.ALTITUDE, Action.LAND),
    ),
    Mode.ACRO: ModeRules("Acro", NAVIGATOR, accepted=NEVER),
    Mode.STABILIZED: ModeRules("Stabilized", NAVIGATOR, accepted=NEVER),
    Mode.OFFBOARD: ModeRules(
        "Offboard",
        STREAM,
        WHERE_IT_IS._replace(setpoints=True),
        armable=True,
        falls_back_to=LAND,
        exception_bit=4,
        override_bit=IN_OFFBOARD,
    ),
    Mode.TAKEOFF: ModeRules(
        "Takeoff",
        NAVIGATOR,
        WHERE_IT_IS,
        armable=True,
        falls_back_to=LAND,
        takes_off=True,
        landed_state_in_air=3,
        override_bit=IN_AUTO,
    ),
    Mode.HOLD: ModeRules(
        "Hold",
        NAVIGATOR,
        WHERE_IT_IS,
        armable=True,
        falls_back_to=LAND,
        exception_bit=2,
        override_bit=IN_AUTO,
    ),
    Mode.MISSION: ModeRules(
        "Mission",
        Leader.MISSION,
        WHERE_IT_IS._replace(mission=True),
        armable=True,
        falls_back_to=LAND,
        takes_off=True,
        exception_bit=1,
        override_bit=IN_AUTO,
    ),
    Mode.RTL: ModeRules(
        "Return",
        NAVIGATOR,
        WHERE_IT_IS,
        falls_back_to=LAND,
        on_the_way_down=True,
        override_bit=IN_AUTO,
    ),
    Mode.LAND: ModeRules(
        "Land",
        NAVIGATOR,
        Needs(attitude=True),
        accepted=Acceptance.ALWAYS,
        falls_back_to=TERMINATE,
        on_the_way_down=True,
        landed_state_in_air=4,
        override_bit=IN_AUTO,
    ),
    # There is nobody to follow, and no mark to land on.
    Mode.FOLLOW: ModeRules("Follow Target", NAVIGATOR, accepted=NEVER, override_bit=IN_AUTO),
    Mode.PRECLAND: ModeRules(
        "Precision Landing",
        NAVIGATOR,
        accepted=NEVER,
        on_the_way_down=True,
        override_bit=IN_AUTO,
    ),
    Mode.TERMINATION: ModeRules("Termination", Leader.NOBODY, accepted=NEVER, is_final=True),
}
# Setpoints that ask for an attitude or for rates need no position.
OFFBOARD_BY_ATTITUDE = MODES[Mode.OFFBOARD]._replace(
    needs=Needs(attitude=True, setpoints=True), falls_back_to=TERMINATE
)
# The mode of an action; to disarm is none.
FLOWN: Mapping[Action, Mode] = {
    Action.POSITION: Mode.POSCTL,
    Action.ALTITUDE: Mode.ALTCTL,
    Action.STABILIZED: Mode.STABILIZED,
    Action.HOLD: Mode.HOLD,
    Action.RETURN: Mode.RTL,
    Action.LAND: Mode.LAND,
    Action.TERMINATE: Mode.TERMINATION,
}
