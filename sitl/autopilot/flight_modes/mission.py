"""Fly a mission: item by item, a leg a tick for the navigator to follow.

Each item that takes time goes through some of these phases; the others are done at once.

CLIMB --altitude--> TRAVEL --within the radius--> TURN --heading--> STAY --time--> next item
                    TURN, above the place of a LAND --heading--> LAND --on the ground--> next item
no next item --> END: hold there;  RETURN_TO_LAUNCH --> END, and the mode becomes RTL
"""

import math
from collections.abc import Callable
from enum import Enum
from math import isnan
from typing import NamedTuple

from sitl.autopilot.control.heading import FacingParameters
from sitl.autopilot.flight_modes import mission_plan
from sitl.autopilot.parameters import Parameters
from sitl.clock import SECOND_US
from sitl.frames import ned_from_geodetic, wrap_pi, yaw_of
from sitl.records.missions import MissionItem, Plan
from sitl.records.motion import Vector3
from sitl.records.sensing import Estimate
from sitl.records.texts import CRITICAL, INFO

Say = Callable[[int, str], None]  # MAV_SEVERITY, text

NAN = math.nan
ORIGIN: Vector3 = (0.0, 0.0, 0.0)
NOWHERE: Vector3 = (NAN, NAN, NAN)
MAX_DEEDS = 2000  # jumps and the like in a row, before a mission counts as finished
JUMPS_MAX = 0xFFFF


class Phase(Enum):
    """How far the current item has come."""

    CLIMB = 1
    TRAVEL = 2
    TURN = 3
    STAY = 4
    LAND = 5
    END = 6


class Leg(NamedTuple):
    """Where to go now; NaN: come to a stop, or keep the heading."""

    target_ned: Vector3 = NOWHERE  # m
    yaw_rad: float = NAN
    climbs: bool = False  # straight up, at the take-off's speed
    lands: bool = False  # straight down, whatever the target's height


class MissionFlight:
    """Keeps the current item and its phase."""

    def __init__(self, parameters: Parameters, origin: Vector3, say: Say) -> None:
        self.index = 0
        self.finished = False
        self.started = False
        self.failed = False  # until there is another plan
        self.speed_m_s = NAN  # horizontal; NaN: the usual one
        self.reached: list[int] = []  # not yet told
        self._origin = origin  # latitude deg, longitude deg, altitude m of the local frame
        self._say = say
        self._plan: Plan = ()
        self._jumps: dict[int, int] = {}  # made, by the item
        self._home_ned = ORIGIN
        self._phase = Phase.END
        self._target = NOWHERE
        self._yaw_rad = NAN
        self._climb_to = NAN  # m, down
        self._arrived_us = 0
        self._is_changed = False  # the item was set from outside
        self._wants_return = False  # RTL is due, and not yet begun
        self.load(parameters)

    def load(self, parameters: Parameters) -> None:
        """Take radii and heights from the parameters."""
        self._radius = parameters["NAV_ACC_RAD"]
        self._altitude_radius = parameters["NAV_MC_ALT_RAD"]
        self._takeoff_altitude = parameters["MIS_TAKEOFF_ALT"]
        self._facing = FacingParameters.resolve(parameters.values)

    def take(self, plan: Plan, current: int) -> None:
        """Take a new plan; one that is being flown begins at once."""
        self._plan = plan
        self.started = self.failed = False
        self.set_current(current)

    def set_current(self, index: int) -> None:
        """Go to an item next."""
        self.index, self.finished, self._is_changed = index, False, True
        self._jumps.clear()

    def start(self, estimate: Estimate, home_ned: Vector3, *, landed: bool) -> None:
        """Begin, or go on at the current item; a mission that was finished begins anew."""
        self._home_ned = home_ned
        if self.finished and landed:
            self.set_current(0)
        self._wants_return, self.started = False, True
        self._say(INFO, "Executing Mission")
        self._begin(estimate, landed=landed)

    def wants_climb(self, estimate: Estimate, *, landed: bool) -> bool:
        """Whether a vehicle on the ground is to take off; what can be done there is done."""
        if self._is_changed:
            self._begin(estimate, landed=landed)
        if landed and (self._phase is Phase.LAND or self._has_stayed(estimate)):
            self._go_on(estimate, landed=True)
        return self._phase in (Phase.CLIMB, Phase.TRAVEL, Phase.TURN)

    def update(self, estimate: Estimate) -> Leg:
        """Give the leg to fly at this moment."""
        if self._is_changed:
            self._begin(estimate, landed=False)
        if self._phase is Phase.CLIMB:
            if estimate.position_ned[2] - self._climb_to > self._altitude_radius:
                return Leg((NAN, NAN, self._climb_to), climbs=True)
            self._phase = Phase.TRAVEL
        if self._phase is Phase.TRAVEL and self._has_arrived(estimate):
            self._arrived_us = estimate.time_us
            self._phase = Phase.TURN
        if self._phase is Phase.TURN:
            self._turn(estimate)
        if self._has_stayed(estimate):
            self._go_on(estimate, landed=False)
        return Leg(
            self._target,
            self._yaw_rad,
            climbs=self._phase is Phase.CLIMB,
            lands=self._phase is Phase.LAND,
        )

    def take_return(self) -> bool:
        """Whether the mission now asks to return; true once."""
        wanted, self._wants_return = self._wants_return, False
        return wanted

    def _go_on(self, estimate: Estimate, *, landed: bool) -> None:
        self.reached.append(self.index)
        self.index += 1
        self._begin(estimate, landed=landed)

    def _begin(self, estimate: Estimate, *, landed: bool) -> None:
        """Begin the current item, after all those that take no time."""
        self._is_changed = False
        self.speed_m_s = self._speed_before(self.index)
        for _ in range(MAX_DEEDS):
            if self.index >= len(self._plan) or self._wants_return:
                break
            item = self._plan[self.index]
            if item.command in mission_plan.PLACES or item.command == mission_plan.DELAY:
                self._begin_item(item, estimate, landed=landed)
                return
            self.reached.append(self.index)
            self.index = self._do(item, landed=landed)
        self._finish(landed=landed)

    def _begin_item(self, item: MissionItem, estimate: Estimate, *, landed: bool) -> None:
        self._arrived_us = estimate.time_us
        if item.command == mission_plan.DELAY:
            self._phase = Phase.STAY  # where the last item has led
            return
        self._target = self._place_of(item, estimate)
        self._yaw_rad = wrap_pi(math.radians(item.params[3]))
        lands = item.command == mission_plan.LAND
        if lands:
            self._target = (*self._target[:2], estimate.position_ned[2])
        on_the_spot = lands and (landed or isnan(self._target[0]))
        self._phase = Phase.LAND if on_the_spot else Phase.TRAVEL
        if not lands and (landed or item.command == mission_plan.TAKEOFF):
            self._begin_climb(estimate, landed=landed)

    def _begin_climb(self, estimate: Estimate, *, landed: bool) -> None:
        """Go straight up first, where the vehicle is below the item's altitude or on the ground."""
        down = estimate.position_ned[2]
        ground = down if landed else self._home_ned[2]
        self._climb_to = min(self._target[2], ground - self._takeoff_altitude)
        if landed or down - self._climb_to > self._altitude_radius:
            self._phase = Phase.CLIMB
            height = self._home_ned[2] - self._climb_to
            self._say(INFO, f"Climb to {height:.1f} meters above home")

    def _do(self, item: MissionItem, *, landed: bool) -> int:
        """Carry out what takes no time; the index of the item that follows."""
        if item.command == mission_plan.RETURN_TO_LAUNCH:
            self._wants_return = not landed
        elif item.command == mission_plan.DO_CHANGE_SPEED:
            self.speed_m_s = speed_of(item, self.speed_m_s)
        elif item.command == mission_plan.DO_JUMP:
            made, repeats = self._jumps.get(self.index, 0), int(item.params[1])
            if made < (JUMPS_MAX if repeats < 0 else repeats):
                self._jumps[self.index] = made + 1
                return int(item.params[0])
        return self.index + 1

    def _finish(self, *, landed: bool) -> None:
        """Hold where the last item has led, or leave the way to the return."""
        self._phase, self.finished = Phase.END, True
        self.index = max(0, min(self.index, len(self._plan)) - 1)
        if not self._plan:
            self._target = NOWHERE
        if not self._wants_return:
            self._say(INFO, f"Mission finished, {'landed' if landed else 'loitering'}")

    def _turn(self, estimate: Estimate) -> None:
        """Wait for the heading that is asked for; one that is forced may be late."""
        item = self._plan[self.index]
        forced = item.command == mission_plan.LOITER_TIME and item.params[1] > 0.0
        if self._facing.accepts(self._yaw_rad, yaw_of(estimate.q_ned_frd), forced=forced):
            self._phase = Phase.LAND if item.command == mission_plan.LAND else Phase.STAY
        elif not self.failed and self._facing.gives_up(estimate.time_us - self._arrived_us):
            self.failed = True
            self._say(CRITICAL, "unable to reach heading within timeout")

    def _place_of(self, item: MissionItem, estimate: Estimate) -> Vector3:
        """Local place of an item; where it leaves it open, the place that is held or reached."""
        latitude, longitude = item.latitude_deg, item.longitude_deg
        x, y, z = ned_from_geodetic((latitude, longitude, item.z), self._origin)
        if item.frame in mission_plan.RELATIVE_FRAMES:
            z = self._home_ned[2] - item.z
        if isnan(x) or isnan(y):
            x, y = (NAN, NAN) if item.command == mission_plan.LAND else estimate.position_ned[:2]
        return (x, y, z)

    def _has_arrived(self, estimate: Estimate) -> bool:
        """Whether the vehicle is near enough to the place."""
        item, (x, y, z) = self._plan[self.index], estimate.position_ned
        radius = item.params[1] if item.command == mission_plan.WAYPOINT else NAN
        if not radius > 0.0:
            radius = self._radius
        if math.hypot(self._target[0] - x, self._target[1] - y) > radius:
            return False
        return abs(self._target[2] - z) <= self._altitude_radius

    def _has_stayed(self, estimate: Estimate) -> bool:
        if self._phase is not Phase.STAY:
            return False
        item = self._plan[self.index]
        if item.command == mission_plan.LOITER_UNLIMITED:
            return False
        waits = item.command in mission_plan.WAITS and item.params[0] > 0.0
        stay_s = item.params[0] if waits else 0.0
        return estimate.time_us - self._arrived_us >= stay_s * SECOND_US

    def _speed_before(self, index: int) -> float:
        speed = NAN
        for item in self._plan[:index]:
            if item.command == mission_plan.DO_CHANGE_SPEED:
                speed = speed_of(item, speed)
        return speed


def speed_of(item: MissionItem, present_m_s: float) -> float:
    """Speed after a DO_CHANGE_SPEED; what is not positive leaves it, -2 resets it."""
    wanted = item.params[1]
    if wanted == mission_plan.SPEED_RESET:
        return NAN
    return wanted if wanted > 0.0 else present_m_s
