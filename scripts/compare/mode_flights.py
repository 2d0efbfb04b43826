"""Scripts that fly every mode: hold, return, land, missions, sticks, offboard."""

import math
from collections.abc import Callable
from typing import Any

from pymavlink.dialects.v20 import development as mavlink

from scripts.compare.pilot import (
    LOCAL_NED,
    Pilot,
    ScriptedFlight,
    Setpoint,
    local,
    silence,
)
from scripts.compare.words import (
    FENCE,
    HOME_AMSL_M,
    MISSION,
    NAN,
    RALLY,
    Item,
    change_mode,
    command,
    parameter,
    place,
    reposition,
)

LAND, RETURN, PAUSE, SET_CURRENT, START, SPEED = 21, 20, 193, 224, 300, 178
WAYPOINT, LOITER_TIME, TAKE_OFF, LOITER_TO, DELAY, JUMP = 16, 19, 22, 31, 93, 177
POSITION, VELOCITY, ACCELERATION, ATTITUDE_ONLY, RATES_ONLY = 0x9F8, 0x9C7, 0xC3F, 0x07, 0x80
LOW_RETURN = {"RTL_RETURN_ALT": 6.0, "RTL_DESCEND_ALT": 3.0, "RTL_LAND_DELAY": 1.0}
MODES = [(main, sub) for main in (1, 2, 3, 5, 6, 7, 10, 42) for sub in (0,)]
AUTO_MODES = [(4, sub) for sub in range(1, 12)]


def _hold_and_land(pilot: Pilot) -> None:
    pilot.take_off()
    pilot.fly(4.0, reposition(8.0, -4.0, 5.0, 1.0))
    pilot.fly(2.0, command(SPEED, 0.0, 2.0))
    pilot.fly(3.0, reposition(-3.0, 2.0, 3.0))
    pilot.fly(8.0, command(LAND))
    pilot.fly(1.0, command(400, 1.0))  # armed, and disarmed by itself
    pilot.fly(4.0)


def _return(pilot: Pilot) -> None:
    pilot.take_off(4.0)
    pilot.fly(6.0, reposition(15.0, 5.0, 4.0))
    pilot.fly(25.0, command(RETURN))


def _rally(pilot: Pilot) -> None:
    pilot.upload(RALLY, Item(5100, north_m=12.0, east_m=-9.0), Item(5100, north_m=-40.0))
    pilot.take_off(4.0)
    pilot.fly(4.0, reposition(12.0, 2.0, 4.0))
    pilot.fly(22.0, change_mode(4, 5))


def _mission(pilot: Pilot) -> None:
    pilot.upload(
        MISSION,
        Item(TAKE_OFF, height_m=4.0),
        Item(WAYPOINT, (1.0, 1.0, 0.0, 90.0), 6.0, 3.0, 4.0),
        Item(SPEED, (0.0, 3.0, 0.0, 0.0), frame=2),
        Item(WAYPOINT, (0.0, 0.0, 0.0, NAN), 12.0, -3.0, 5.0),
        Item(JUMP, (3.0, 1.0, 0.0, 0.0), frame=2),
        Item(LOITER_TIME, (1.5, 0.0, 0.0, NAN), 8.0, 0.0, 5.0),
        Item(DELAY, (1.0, 0.0, 0.0, 0.0), frame=2),
        Item(LOITER_TO, (0.0, 0.0, 0.0, NAN), 4.0, 0.0, 6.0),
        Item(RETURN, frame=2),
    )
    pilot.fly(1.5)
    pilot.fly(9.0, command(START))
    pilot.fly(2.0, command(PAUSE, 0.0))
    pilot.fly(4.0, command(PAUSE, 1.0))
    pilot.fly(3.0, command(SET_CURRENT, 5.0))
    pilot.fly(26.0, mavlink.MAVLink_mission_set_current_message(1, 1, 7))
    pilot.fly(0.5, mavlink.MAVLink_mission_clear_all_message(1, 1, 255))


def _mission_that_lands(pilot: Pilot) -> None:
    pilot.take_off()
    pilot.upload(MISSION, Item(WAYPOINT, (0.0, 0.0, 0.0, NAN), 5.0, 0.0, 3.0), Item(LAND))
    pilot.fly(0.05, change_mode(4, 4))  # too early
    pilot.fly(0.3)
    pilot.fly(16.0, change_mode(4, 4))


def _refused_plans(pilot: Pilot) -> None:
    for item in (
        Item(34),
        Item(WAYPOINT, (NAN, math.inf, 0.0, NAN)),
        Item(WAYPOINT, frame=10),
        Item(WAYPOINT, height_m=math.inf),
        Item(JUMP, (9.0, 1.0, 0.0, 0.0), frame=2),
    ):
        pilot.upload(MISSION, item)
    pilot.upload(FENCE, Item(5001, (4.0, 0.0, 0.0, NAN)))
    pilot.upload(FENCE, Item(5003, (-1.0, 0.0, 0.0, NAN)))
    pilot.upload(RALLY, Item(WAYPOINT))
    pilot.fly(1.0, command(START))
    pilot.say(mavlink.MAVLink_mission_count_message(1, 1, 3, MISSION))  # and nothing more
    pilot.fly(6.0)


def _sticks(pilot: Pilot) -> None:
    pilot.sticks = (0, 0, 500, 0)
    pilot.fly(1.5, change_mode(3))
    pilot.fly(0.2, command(400, 1.0))
    for sticks in ((0, 0, 900, 0), (600, 0, 500, 0), (0, -800, 500, 300), (0, 0, 200, -900)):
        pilot.sticks = sticks
        pilot.fly(3.0)
    pilot.sticks = (0, 0, 500, 0)
    pilot.fly(1.0, change_mode(2))
    for sticks in ((500, 0, 500, 0), (0, 500, 700, 500), (0, 0, 500, 0)):
        pilot.sticks = sticks
        pilot.fly(2.0)
    pilot.fly(2.0, change_mode(4, 3))
    pilot.sticks = (900, 0, 500, 0)  # takes over
    pilot.fly(2.0)
    pilot.sticks = (0, 0, 0, 0)
    pilot.fly(8.0)


def _override_offboard(pilot: Pilot) -> None:
    pilot.take_off()
    pilot.sticks = (0, 0, 500, 0)
    pilot.enter_offboard(local((1.0, 0.0, 0.0)))
    pilot.fly(2.0)
    pilot.sticks = (0, 900, 500, 0)
    pilot.fly(3.0)


def _through(*setpoints: Setpoint, seconds: float = 2.5) -> Callable[[Pilot], None]:
    """Fly setpoint after setpoint in offboard, then without any."""

    def script(pilot: Pilot) -> None:
        pilot.take_off()
        pilot.enter_offboard(setpoints[0])
        for setpoint in setpoints:
            pilot.setpoint = setpoint
            pilot.fly(seconds)
        pilot.setpoint = silence
        pilot.fly(3.0)

    return script


def _global(north_m: float, frame: int, height_m: float) -> Setpoint:
    latitude, longitude = place(north_m, 2.0)
    degrees = (round(latitude * 1e7), round(longitude * 1e7))
    return lambda stamp_ms: mavlink.MAVLink_set_position_target_global_int_message(
        stamp_ms, 1, 1, frame, 0xDF8, *degrees, height_m, *[0.0] * 8
    )


def _attitude(mask: int, q: list[float], rates: list[float], thrust: float) -> Setpoint:
    return lambda stamp_ms: mavlink.MAVLink_set_attitude_target_message(
        stamp_ms, 1, 1, mask, q, *rates, thrust
    )


def _accelerate(north: float, down: float) -> Setpoint:
    return lambda stamp_ms: mavlink.MAVLink_set_position_target_local_ned_message(
        stamp_ms, 1, 1, LOCAL_NED, ACCELERATION, *[0.0] * 6, north, 0.0, down, 0.0, 0.0
    )


def _every_mode(pilot: Pilot) -> None:
    wanted: list[Any] = [change_mode(*mode) for mode in MODES + AUTO_MODES if mode != (10, 0)]
    pilot.fly(1.5)
    for message in wanted:
        pilot.fly(0.4, message)
    pilot.fly(0.4, change_mode(4, 3))
    pilot.take_off()
    for message in wanted:
        pilot.fly(0.6, message)
        pilot.fly(0.4, change_mode(4, 3))
    pilot.fly(0.5, mavlink.MAVLink_set_mode_message(1, 1, 6 << 24 | 4 << 16))


def _parameters_in_flight(pilot: Pilot) -> None:
    pilot.take_off()
    pilot.enter_offboard(local((2.0, 1.0, 0.0), 0.3))
    pilot.fly(2.0, parameter("MPC_XY_VEL_P_ACC", 3.0), parameter("MC_ROLLRATE_P", 0.25))
    pilot.fly(2.0, parameter("MPC_XY_VEL_MAX", 1.0), parameter("MC_YAW_P", 1.0))
    pilot.fly(2.0, parameter("NOT_THERE", 1.0), parameter("MPC_THR_HOVER", 0.3))
    pilot.fly(4.0, parameter("MPC_LAND_SPEED", 1.0), change_mode(4, 6))


HOVER = [1.0, 0.0, 0.0, 0.0]
LEANING = [math.cos(0.1), 0.0, -math.sin(0.1), 0.0]
MODE_FLIGHTS = {
    "hold-and-land": ScriptedFlight(_hold_and_land),
    "return": ScriptedFlight(_return, LOW_RETURN),
    "return-to-rally-point": ScriptedFlight(_rally, {**LOW_RETURN, "RTL_TYPE": 1}),
    "mission": ScriptedFlight(_mission, LOW_RETURN),
    "mission-that-lands": ScriptedFlight(_mission_that_lands),
    "refused-plans": ScriptedFlight(_refused_plans),
    "sticks": ScriptedFlight(_sticks),
    "sticks-override-offboard": ScriptedFlight(_override_offboard, {"COM_RC_OVERRIDE": 3}),
    "offboard-velocity": ScriptedFlight(
        _through(
            local((2.0, 0.5, -0.3), 0.4),
            local((0.0, -1.0, 0.3), mask=VELOCITY, yaw=1.0),
            local((1.0, 1.0, 0.0), frame=LOCAL_NED),
            local((NAN, 0.0, 0.0)),
        )
    ),
    "offboard-position": ScriptedFlight(
        _through(
            local(position=(4.0, 2.0, -4.0), yaw=0.5, frame=LOCAL_NED, mask=POSITION),
            local(position=(-1.0, 0.0, -2.0), yaw=-2.0, frame=LOCAL_NED, mask=POSITION),
            _global(3.0, 5, HOME_AMSL_M + 3.0),
            _global(-3.0, 6, 4.0),
            _global(-3.0, 2, 4.0),
            seconds=3.0,
        )
    ),
    "offboard-acceleration": ScriptedFlight(
        _through(_accelerate(1.0, 0.0), _accelerate(-1.5, -0.2), seconds=1.5)
    ),
    "offboard-attitude": ScriptedFlight(
        _through(
            _attitude(ATTITUDE_ONLY, HOVER, [0.0] * 3, 0.72),
            _attitude(ATTITUDE_ONLY, LEANING, [0.0] * 3, 0.74),
            _attitude(ATTITUDE_ONLY, [0.0] * 4, [0.0] * 3, 0.7),
            seconds=1.5,
        )
    ),
    "offboard-rates": ScriptedFlight(
        _through(
            _attitude(RATES_ONLY, HOVER, [0.0, 0.2, 0.5], 0.72),
            _attitude(RATES_ONLY, HOVER, [0.3, -0.2, -0.5], 0.72),
            seconds=1.0,
        )
    ),
    "every-mode": ScriptedFlight(_every_mode),
    "parameters-in-flight": ScriptedFlight(_parameters_in_flight),
    "other-options": ScriptedFlight(
        _hold_and_land,
        options=("--direction=ccw", "--laps=2", "--perfect-estimate", "--ready-after=2"),
    ),
}
