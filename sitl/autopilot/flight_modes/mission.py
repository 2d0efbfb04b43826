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
from typing import NamedTuple, Self

from sitl.autopilot.control.heading import FacingParameters
from sitl.autopilot.flight_modes import mission_plan
from sitl.autopilot.parameters import ParameterValues
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
IMMEDIATE_MAX = 2000  # jumps and the like in a row, before a mission counts as finished
JUMPS_MAX = 0xFFFF


class ItemPhase(Enum):
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
    lands: bool = False  # straight down, whatever the target's height; slower near the ground
    sinks: bool = False  # likewise, always slowly


class MissionParameters(NamedTuple):
    """What counts as arrived, and how high a mission begins."""

    radius_m: float  # NAV_ACC_RAD
    altitude_radius_m: float  # NAV_MC_ALT_RAD
    takeoff_height_m: float  # MIS_TAKEOFF_ALT
    facing: FacingParameters

    @classmethod
    def resolve(cls, values: ParameterValues) -> Self:
        """Take PX4's values, in SI units."""
        return cls(
            radius_m=values["NAV_ACC_RAD"],
            altitude_radius_m=values["NAV_MC_ALT_RAD"],
            takeoff_height_m=values["MIS_TAKEOFF_ALT"],
            facing=FacingParameters.resolve(values),
        )


class MissionFlightState(NamedTuple):
    """Which item is flown, and how far it has come."""

    current: int = 0  # index of the item
    phase: ItemPhase = ItemPhase.END
    target_ned: Vector3 = NOWHERE
    yaw_rad: float = NAN
    climb_to_m: float = NAN  # down
    arrived_us: int = 0
    home_ned: Vector3 = ORIGIN
    speed_m_s: float = NAN  # horizontal; NaN: the usual one
    started: bool = False
    finished: bool = False
    failed: bool = False  # until there is another plan
    is_changed: bool = False  # the item was set from outside
    wants_return: bool = False  # RTL is due, and not yet begun


class MissionFlight:
    """Flies a plan: keeps the current item and its phase."""

    def __init__(self, parameters: MissionParameters, origin: Vector3, say: Say) -> None:
        self.parameters = parameters
        self.state = MissionFlightState()
        self._origin = origin  # latitude deg, longitude deg, altitude m of the local frame
        self._say = say
        self._plan: Plan = ()
        self._jumps: dict[int, int] = {}  # made, by the item
        self._reached: list[int] = []  # not yet told

    def take(self, plan: Plan, current: int) -> None:
        """Take a new plan; one that is being flown begins at once."""
        self._plan = plan
        self.state = self.state._replace(started=False, failed=False)
        self.set_current(current)

    def set_current(self, index: int) -> None:
        """Go to an item next."""
        self.state = self.state._replace(current=index, finished=False, is_changed=True)
        self._jumps.clear()

    def start(self, estimate: Estimate, home_ned: Vector3, *, landed: bool) -> None:
        """Begin, or go on at the current item; a mission that was finished begins anew."""
        if self.state.finished and landed:
            self.set_current(0)
        self.state = self.state._replace(home_ned=home_ned, wants_return=False, started=True)
        self._say(INFO, "Executing Mission")
        self._begin(estimate, landed=landed)

    def wants_climb(self, estimate: Estimate, *, landed: bool) -> bool:
        """Whether a vehicle on the ground is to take off; what can be done there is done."""
        if self.state.is_changed:
            self._begin(estimate, landed=landed)
        if landed and (self.state.phase is ItemPhase.LAND or self._has_stayed(estimate)):
            self._go_on(estimate, landed=True)
        return self.state.phase in (ItemPhase.CLIMB, ItemPhase.TRAVEL, ItemPhase.TURN)

    def update(self, estimate: Estimate) -> Leg:
        """Give the leg to fly at this moment."""
        if self.state.is_changed:
            self._begin(estimate, landed=False)
        if self.state.phase is ItemPhase.CLIMB:
            climb_to = self.state.climb_to_m
            if estimate.position_ned[2] - climb_to > self.parameters.altitude_radius_m:
                return Leg((NAN, NAN, climb_to), climbs=True)
            self.state = self.state._replace(phase=ItemPhase.TRAVEL)
        if self.state.phase is ItemPhase.TRAVEL and self._has_arrived(estimate):
            self.state = self.state._replace(phase=ItemPhase.TURN, arrived_us=estimate.time_us)
        if self.state.phase is ItemPhase.TURN:
            self._turn(estimate)
        if self._has_stayed(estimate):
            self._go_on(estimate, landed=False)
        state = self.state
        return Leg(
            state.target_ned,
            state.yaw_rad,
            climbs=state.phase is ItemPhase.CLIMB,
            lands=state.phase is ItemPhase.LAND,
        )

    def take_return(self) -> bool:
        """Whether the mission now asks to return; true once."""
        if not self.state.wants_return:
            return False
        self.state = self.state._replace(wants_return=False)
        return True

    def drain_reached(self) -> list[int]:
        """Hand over the items that were reached since the last call."""
        if not self._reached:
            return []
        reached, self._reached = self._reached, []
        return reached

    def _go_on(self, estimate: Estimate, *, landed: bool) -> None:
        index = self.state.current
        self._reached.append(index)
        self.state = self.state._replace(current=index + 1)
        self._begin(estimate, landed=landed)

    def _begin(self, estimate: Estimate, *, landed: bool) -> None:
        """Begin the current item, after all those that take no time."""
        speed = mission_plan.speed_before(self._plan, self.state.current)
        self.state = self.state._replace(is_changed=False, speed_m_s=speed)
        for _ in range(IMMEDIATE_MAX):
            index = self.state.current
            if index >= len(self._plan) or self.state.wants_return:
                break
            item = self._plan[index]
            if item.command in mission_plan.PLACES or item.command == mission_plan.DELAY:
                self._begin_item(item, estimate, landed=landed)
                return
            self._reached.append(index)
            self._do(item, landed=landed)
        self._finish(landed=landed)

    def _begin_item(self, item: MissionItem, estimate: Estimate, *, landed: bool) -> None:
        state = self.state._replace(arrived_us=estimate.time_us)
        if item.command == mission_plan.DELAY:  # where the last item has led
            self.state = state._replace(phase=ItemPhase.STAY)
            return
        x, y, z = self._place_of(item, estimate)
        lands = item.command == mission_plan.LAND
        on_the_spot = lands and (landed or isnan(x))
        self.state = state._replace(
            phase=ItemPhase.LAND if on_the_spot else ItemPhase.TRAVEL,
            target_ned=(x, y, estimate.position_ned[2] if lands else z),
            yaw_rad=wrap_pi(math.radians(item.params[3])),
        )
        if not lands and (landed or item.command == mission_plan.TAKEOFF):
            self._begin_climb(estimate, landed=landed)

    def _begin_climb(self, estimate: Estimate, *, landed: bool) -> None:
        """Go straight up first, where the vehicle is below the item's altitude or on the ground."""
        state, parameters, down = self.state, self.parameters, estimate.position_ned[2]
        ground = down if landed else state.home_ned[2]
        climb_to = min(state.target_ned[2], ground - parameters.takeoff_height_m)
        self.state = state._replace(climb_to_m=climb_to)
        if landed or down - climb_to > parameters.altitude_radius_m:
            self.state = self.state._replace(phase=ItemPhase.CLIMB)
            self._say(INFO, f"Climb to {state.home_ned[2] - climb_to:.1f} meters above home")

    def _do(self, item: MissionItem, *, landed: bool) -> None:
        """Carry out what takes no time, and go to the item that follows."""
        state = self.state
        index, following = state.current, state.current + 1
        if item.command == mission_plan.RETURN_TO_LAUNCH:
            state = state._replace(wants_return=not landed)
        elif item.command == mission_plan.DO_CHANGE_SPEED:
            state = state._replace(speed_m_s=mission_plan.speed_of(item, state.speed_m_s))
        elif item.command == mission_plan.DO_JUMP:
            made, repeats = self._jumps.get(index, 0), int(item.params[1])
            if made < (JUMPS_MAX if repeats < 0 else repeats):
                self._jumps[index] = made + 1
                following = int(item.params[0])
        self.state = state._replace(current=following)

    def _finish(self, *, landed: bool) -> None:
        """Hold where the last item has led, or leave the way to the return."""
        state = self.state
        self.state = state._replace(
            phase=ItemPhase.END,
            finished=True,
            current=max(0, min(state.current, len(self._plan)) - 1),
            target_ned=state.target_ned if self._plan else NOWHERE,
        )
        if not state.wants_return:
            self._say(INFO, f"Mission finished, {'landed' if landed else 'loitering'}")

    def _turn(self, estimate: Estimate) -> None:
        """Wait for the heading that is asked for; one that is forced may be late."""
        state, facing = self.state, self.parameters.facing
        item = self._plan[state.current]
        forced = item.command == mission_plan.LOITER_TIME and item.params[1] > 0.0
        if facing.accepts(state.yaw_rad, yaw_of(estimate.q_ned_frd), forced=forced):
            lands = item.command == mission_plan.LAND
            self.state = state._replace(phase=ItemPhase.LAND if lands else ItemPhase.STAY)
        elif not state.failed and facing.gives_up(estimate.time_us - state.arrived_us):
            self.state = state._replace(failed=True)
            self._say(CRITICAL, "unable to reach heading within timeout")

    def _place_of(self, item: MissionItem, estimate: Estimate) -> Vector3:
        """Local place of an item; where it leaves it open, the place that is held or reached."""
        latitude, longitude = item.latitude_deg, item.longitude_deg
        x, y, z = ned_from_geodetic((latitude, longitude, item.z), self._origin)
        if item.frame in mission_plan.RELATIVE_FRAMES:
            z = self.state.home_ned[2] - item.z
        if isnan(x) or isnan(y):
            x, y = (NAN, NAN) if item.command == mission_plan.LAND else estimate.position_ned[:2]
        return (x, y, z)

    def _has_arrived(self, estimate: Estimate) -> bool:
        """Whether the vehicle is near enough to the place."""
        item, (x, y, z) = self._plan[self.state.current], estimate.position_ned
        north, east, down = self.state.target_ned
        radius = item.params[1] if item.command == mission_plan.WAYPOINT else NAN
        if not radius > 0.0:
            radius = self.parameters.radius_m
        if math.hypot(north - x, east - y) > radius:
            return False
        return abs(down - z) <= self.parameters.altitude_radius_m

    def _has_stayed(self, estimate: Estimate) -> bool:
        if self.state.phase is not ItemPhase.STAY:
            return False
        item = self._plan[self.state.current]
        if item.command == mission_plan.LOITER_UNLIMITED:
            return False
        waits = item.command in mission_plan.WAITS and item.params[0] > 0.0
        stay_s = item.params[0] if waits else 0.0
        return estimate.time_us - self.state.arrived_us >= stay_s * SECOND_US
