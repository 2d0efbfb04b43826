"""Scripts that provoke every failsafe with each of its actions."""

from collections.abc import Callable

from pymavlink.dialects.v20 import development as mavlink

from scripts.compare.pilot import COMPANION, Pilot, ScriptedFlight, local, silence
from scripts.compare.words import (
    FENCE,
    MISSION,
    Item,
    change_mode,
    command,
    parameter,
    reposition,
)

TERMINATE, ARM, FORCE = 185, 400, 21196.0
SOON = {"COM_FAIL_ACT_T": 2.0, "RTL_RETURN_ALT": 4.0, "RTL_DESCEND_ALT": 3.0}
CIRCLE, CIRCLE_OUTSIDE, POLYGON, POLYGON_OUTSIDE = 5003, 5004, 5001, 5002


def _lose_setpoints(pilot: Pilot) -> None:
    pilot.take_off()
    pilot.enter_offboard(local((1.5, 0.0, 0.0)))
    pilot.fly(1.0)
    pilot.setpoint = silence
    pilot.fly(4.0)
    pilot.setpoint = local((-1.0, 0.0, 0.0))  # they come back
    pilot.fly(2.0)
    pilot.setpoint = silence
    pilot.fly(2.0)


def _lose_setpoints_with_sticks(pilot: Pilot) -> None:
    pilot.sticks = (300, 0, 500, 0)
    _lose_setpoints(pilot)


def _lose_station(pilot: Pilot) -> None:
    pilot.take_off()
    pilot.fly(2.0, reposition(12.0, 0.0, 2.5))
    pilot.greets = False
    pilot.fly(9.0)
    pilot.greets = True
    pilot.fly(2.0)
    pilot.fly(2.0, change_mode(4, 3))


def _lose_station_in_mission(pilot: Pilot) -> None:
    pilot.upload(MISSION, Item(22, height_m=3.0), Item(16, north_m=30.0, height_m=3.0))
    pilot.fly(1.5)
    pilot.fly(8.0, command(300))
    pilot.greets = False
    pilot.fly(10.0)


def _lose_sticks(pilot: Pilot) -> None:
    pilot.sticks = (0, 0, 500, 0)
    pilot.take_off()
    pilot.fly(0.5, change_mode(3))
    pilot.sticks = (700, 0, 500, 0)
    pilot.fly(2.0)
    pilot.sticks = None
    pilot.fly(5.0)
    pilot.sticks = (0, 0, 500, 0)
    pilot.fly(2.0)
    pilot.fly(2.0, change_mode(3))


def _lose_companion(pilot: Pilot) -> None:
    pilot.take_off()
    pilot.say(mavlink.MAVLink_heartbeat_message(18, 8, 0, 0, 4, 3), sender=COMPANION)
    pilot.fly(7.0)


def _leave_fence(pilot: Pilot) -> None:
    pilot.upload(FENCE, Item(CIRCLE, (7.0, 0.0, 0.0, 0.0)))
    pilot.take_off()
    pilot.enter_offboard(local((3.0, 0.0, 0.0)))
    pilot.fly(6.0)
    pilot.setpoint = local((-2.0, 0.0, 0.0))
    pilot.fly(1.0, change_mode(6))
    pilot.fly(3.0)


def _leave_limits(pilot: Pilot) -> None:
    pilot.take_off()
    pilot.enter_offboard(local((0.0, 0.0, -2.0)))
    pilot.fly(3.0)
    pilot.fly(2.0, change_mode(4, 3))
    pilot.fly(1.0, parameter("GF_MAX_VER_DIST", 0.0))
    pilot.fly(3.0, parameter("GF_MAX_HOR_DIST", 3.0), reposition(5.0, 0.0, 3.0))
    pilot.enter_offboard(local((2.0, 0.0, 0.0)))
    pilot.fly(4.0)


def _fences_refuse(pilot: Pilot) -> None:
    corners = ((-5.0, -5.0), (-5.0, 9.0), (9.0, 9.0), (9.0, -5.0))
    square = [Item(POLYGON, (4.0, 0.0, 0.0, 0.0), north, east) for north, east in corners]
    hole = [
        Item(POLYGON_OUTSIDE, (3.0, 0.0, 0.0, 0.0), north, east)
        for north, east in ((3.0, 3.0), (3.0, 6.0), (6.0, 3.0))
    ]
    pilot.upload(FENCE, *square, *hole, Item(CIRCLE_OUTSIDE, (1.0, 0.0, 0.0, 0.0), -4.0, -4.0))
    pilot.upload(MISSION, Item(22, height_m=3.0), Item(16, north_m=20.0, height_m=3.0))
    pilot.take_off()
    pilot.fly(0.5, command(300))
    for north, east in ((20.0, 0.0), (4.0, 4.0), (-4.0, -4.0), (2.0, 0.0)):
        pilot.fly(1.0, reposition(north, east, 3.0))
    pilot.upload(FENCE, Item(CIRCLE, (2.0, 0.0, 0.0, 0.0), north_m=50.0))
    pilot.fly(1.0)


def _empty_battery(pilot: Pilot) -> None:
    pilot.take_off()
    pilot.fly(8.0, reposition(8.0, 0.0, 3.0))
    pilot.fly(3.0, change_mode(4, 3))
    pilot.fly(4.0)


def _fail_mission(pilot: Pilot) -> None:
    pilot.upload(
        MISSION,
        Item(22, height_m=3.0),
        Item(19, (1.0, 1.0, 0.0, 180.0), 2.0, 0.0, 3.0),
        Item(16, north_m=9.0, height_m=3.0),
    )
    pilot.fly(1.5)
    pilot.fly(22.0, command(300))


def _terminate(pilot: Pilot) -> None:
    pilot.fly(1.5)
    pilot.fly(0.2, command(TERMINATE, 1.0))
    pilot.take_off()
    pilot.fly(0.5, command(TERMINATE, 0.0))
    pilot.fly(3.0, command(TERMINATE, 1.0))
    pilot.fly(1.0, command(ARM, 0.0, FORCE))


def _kill(pilot: Pilot) -> None:
    pilot.take_off()
    pilot.fly(0.3, command(ARM, 0.0))
    pilot.fly(2.0, command(ARM, 0.0, FORCE))
    pilot.fly(1.0, command(ARM, 1.0, FORCE))
    pilot.fly(3.0, command(ARM, 0.5))


def _each(
    name: str,
    script: Callable[[Pilot], None],
    parameter_name: str,
    values: tuple[int, ...],
    parameters: dict[str, float],
) -> dict[str, ScriptedFlight]:
    """Fly a script once for each value of a parameter."""
    return {
        f"{name}-{value}": ScriptedFlight(script, {**SOON, **parameters, parameter_name: value})
        for value in values
    }


FAILSAFE_FLIGHTS = {
    **_each("lose-setpoints", _lose_setpoints, "COM_OBL_RC_ACT", tuple(range(8)), {}),
    **_each(
        "lose-setpoints-with-sticks",
        _lose_setpoints_with_sticks,
        "COM_OBL_RC_ACT",
        (0, 1, 2),
        {"COM_RC_OVERRIDE": 0},
    ),
    **_each("lose-station", _lose_station, "NAV_DLL_ACT", (0, 1, 2, 3, 5, 6), {"COM_DL_LOSS_T": 5}),
    "lose-station-in-mission": ScriptedFlight(
        _lose_station_in_mission,
        {**SOON, "NAV_DLL_ACT": 2, "COM_DLL_EXCEPT": 1, "COM_DL_LOSS_T": 5},
    ),
    **_each("lose-sticks", _lose_sticks, "NAV_RCL_ACT", (1, 2, 3, 5, 6), {}),
    "lose-companion": ScriptedFlight(_lose_companion),
    **_each("leave-fence", _leave_fence, "GF_ACTION", tuple(range(6)), {}),
    "leave-limits": ScriptedFlight(_leave_limits, {**SOON, "GF_MAX_VER_DIST": 5.0}),
    "fences-refuse": ScriptedFlight(_fences_refuse),
    **_each(
        "empty-battery",
        _empty_battery,
        "COM_LOW_BAT_ACT",
        tuple(range(4)),
        {"SIM_BAT_DRAIN": 16.0, "SIM_BAT_MIN_PCT": 0.0},
    ),
    "fail-mission": ScriptedFlight(
        _fail_mission, {**SOON, "MIS_YAW_TMT": 1.0, "MPC_YAWRAUTO_MAX": 5.0}
    ),
    "terminate": ScriptedFlight(_terminate),
    "kill": ScriptedFlight(_kill),
}
