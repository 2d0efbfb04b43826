"""What is uploaded to the vehicle: mission, fence and rally points, checked and kept."""

import math
from typing import NamedTuple, Self

from sitl.autopilot.command.commander import Commander
from sitl.autopilot.command.health_watch import HealthWatch
from sitl.autopilot.command.mode_table import Leader
from sitl.autopilot.flight_modes import rally
from sitl.autopilot.flight_modes.geofence import Geofence
from sitl.autopilot.flight_modes.mission import MissionFlight
from sitl.autopilot.flight_modes.mission_plan import PLACES, RELATIVE_FRAMES, check_item, check_plan
from sitl.autopilot.parameters import ParameterValues
from sitl.frames import ned_from_geodetic
from sitl.records.missions import (
    MissionItem,
    MissionProgress,
    MissionResult,
    MissionState,
    Plan,
    PlanKind,
)
from sitl.records.motion import Vector3
from sitl.records.sensing import NO_ESTIMATE, Estimate
from sitl.records.texts import CRITICAL

SETTLING_US = 100_000  # PX4 was seen to refuse a start within some 100 ms of the upload in flight
ORIGIN: Vector3 = (0.0, 0.0, 0.0)


class PlanParameters(NamedTuple):
    """Where a mission may begin, and a return end."""

    rtl_type: int  # RTL_TYPE
    first_max_m: float  # MIS_DIST_1WP: from the vehicle; not above 0: anywhere

    @classmethod
    def resolve(cls, values: ParameterValues) -> Self:
        """Take PX4's values."""
        return cls(rtl_type=int(values["RTL_TYPE"]), first_max_m=values["MIS_DIST_1WP"])


class Missions:
    """Keeps the three lists, and whether the mission can be flown."""

    def __init__(
        self,
        parameters: PlanParameters,
        commander: Commander,
        health_watch: HealthWatch,
        flight: MissionFlight,
        fence: Geofence,
        origin: Vector3,
    ) -> None:
        self.parameters = parameters
        self.flight = flight
        self._fence = fence
        self._commander = commander
        self._health_watch = health_watch
        self._origin = origin  # latitude deg, longitude deg, altitude m of the local frame
        self._plans: dict[PlanKind, Plan] = dict.fromkeys(PlanKind, ())
        self._estimate = NO_ESTIMATE  # the last with a position, by which plans are judged
        self._home_ned = ORIGIN
        self._uploaded_us = 0
        self._may_be_flown = False  # there is a mission, and the fence permits it
        self._objection: str | None = None  # to the mission; said once
        self._breach: str | None = None

    @property
    def is_available(self) -> bool:
        """Whether there is a mission that may be flown; in flight, a new one takes its time."""
        if not self._may_be_flown:
            return False
        settled = self._estimate.time_us - self._uploaded_us >= SETTLING_US
        return settled or self._commander.state.landed

    def plan(self, kind: PlanKind) -> Plan:
        """Give a list, empty if there is none."""
        return self._plans[kind]

    def check(self, kind: PlanKind, item: MissionItem) -> MissionResult:
        """Say whether an item can be flown or kept."""
        return check_item(kind, item)

    def replace(self, kind: PlanKind, plan: Plan, current: int) -> MissionResult:
        """Take a whole new list, or refuse it and keep the old one."""
        result = check_plan(kind, plan)
        if result is not MissionResult.ACCEPTED:
            return result
        if kind is PlanKind.FENCE and not self._take_fence(plan):
            return MissionResult.DENIED
        self._plans[kind] = plan
        if kind is PlanKind.MISSION:
            self.flight.take(plan, current)
            self._uploaded_us = self._estimate.time_us
        if kind is not PlanKind.RALLY:
            self._objection = None
            self.judge_mission()
        return MissionResult.ACCEPTED

    def set_current(self, sequence: int) -> bool:
        """Go to an item; False if there is no such item."""
        if not 0 <= sequence < len(self._plans[PlanKind.MISSION]):
            return False
        self.flight.set_current(sequence)
        return True

    def drain_reached(self) -> list[int]:
        """Hand over the items that were reached since the last call."""
        return self.flight.drain_reached()

    @property
    def progress(self) -> MissionProgress:
        """Where the mission stands."""
        flight, armed = self.flight.state, self._commander.state.armed
        total = len(self._plans[PlanKind.MISSION])
        in_mission = self._commander.rules.leader is Leader.MISSION
        if total == 0:
            state = MissionState.NO_MISSION
        elif flight.finished:
            state = MissionState.COMPLETE
        elif in_mission and armed:
            state = MissionState.ACTIVE
        else:
            state = MissionState.PAUSED if flight.started else MissionState.NOT_STARTED
        return MissionProgress(flight.current, total, state, in_mission)

    def watch(self, estimate: Estimate, home_ned: Vector3) -> bool:
        """Look whether the fence is breached, and say so when it begins."""
        self._estimate, self._home_ned = estimate, home_ned
        breach = self._fence.breach(estimate.time_us, estimate.position_ned, home_ned)
        begins, self._breach = self._breach is None, breach
        if breach is None or not self._fence.parameters.acts:
            return False
        if begins and self._commander.state.armed:
            self._commander.say(CRITICAL, f"Geofence violation: {breach}")
        return True

    def permits(self, place_ned: Vector3) -> bool:
        """Whether the fence lets the vehicle be led somewhere; NaN: where it is."""
        x, y, z = (
            here if math.isnan(there) else there
            for there, here in zip(place_ned, self._estimate.position_ned, strict=True)
        )
        fence = self._fence
        return not fence.parameters.acts or fence.judge((x, y, z), self._home_ned) is None

    def destination(self, position_ned: Vector3, home_ned: Vector3) -> Vector3:
        """Where a return leads."""
        places = rally.places_of(self._plans[PlanKind.RALLY], self._origin, home_ned)
        return rally.destination(position_ned, home_ned, places, self.parameters.rtl_type)

    def judge_mission(self) -> None:
        """Look whether there is a mission, and one that may be flown; say why not."""
        plan = self._plans[PlanKind.MISSION]
        objection = self._objection_to(plan)
        if objection is not None and objection != self._objection:
            self._commander.say(CRITICAL, objection)
        self._objection = objection
        self._may_be_flown = bool(plan) and objection is None
        self._health_watch.mission_judged(is_available=self.is_available)

    def _take_fence(self, plan: Plan) -> bool:
        """Take a fence, unless the vehicle would be outside of it in flight."""
        self._fence.take(plan)
        if self._commander.state.landed or self.permits(self._estimate.position_ned):
            return True
        self._fence.take(self._plans[PlanKind.FENCE])
        text = "Geofence invalid, doesn't contain current vehicle position"
        self._commander.say(CRITICAL, text)
        return False

    def _objection_to(self, plan: Plan) -> str | None:
        """Say what speaks against a mission: a place out of the fence, or a start far away."""
        places = [
            (n, self._place_of(item)) for n, item in enumerate(plan, 1) if item.command in PLACES
        ]
        for number, place in places:
            if not self.permits(place):
                return f"Geofence violation for waypoint {number}"
        first_max_m = self.parameters.first_max_m
        if places and first_max_m > 0.0:
            away_m = math.dist(places[0][1][:2], self._estimate.position_ned[:2])
            if away_m > first_max_m:  # NaN, the place left open, is here
                return f"First waypoint too far away: {away_m:.0f}m, {first_max_m:.0f} max"
        return None

    def _place_of(self, item: MissionItem) -> Vector3:
        x, y, z = ned_from_geodetic((item.latitude_deg, item.longitude_deg, item.z), self._origin)
        home_down = self._home_ned[2]
        return (x, y, home_down - item.z if item.frame in RELATIVE_FRAMES else z)
