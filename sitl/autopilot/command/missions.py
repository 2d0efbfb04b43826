"""What is uploaded to the vehicle: mission, fence and rally points, checked and kept."""

import math

from sitl.autopilot.command.commander import Commander
from sitl.autopilot.flight_modes import rally
from sitl.autopilot.flight_modes.geofence import Geofence
from sitl.autopilot.flight_modes.mission import MissionFlight
from sitl.autopilot.flight_modes.mission_plan import PLACES, RELATIVE_FRAMES, check_item, check_plan
from sitl.autopilot.parameters import Parameters
from sitl.frames import ned_from_geodetic
from sitl.records.missions import (
    MissionItem,
    MissionProgress,
    MissionResult,
    MissionState,
    Plan,
    PlanKind,
)
from sitl.records.modes import Mode
from sitl.records.motion import Vector3
from sitl.records.texts import CRITICAL

SETTLING_US = 100_000  # PX4 was seen to refuse a start within some 100 ms of the upload in flight
ORIGIN: Vector3 = (0.0, 0.0, 0.0)


class Missions:
    """Keeps the three lists, and whether the mission can be flown."""

    def __init__(self, parameters: Parameters, commander: Commander, origin: Vector3) -> None:
        self.flight = MissionFlight(parameters, origin, commander.say)
        self.fence = Geofence(parameters, origin)
        self._may_be_flown = False  # there is a mission, and the fence permits it
        self._time_us = self._uploaded_us = 0
        self._commander = commander
        self._origin = origin  # latitude deg, longitude deg, altitude m of the local frame
        self._plans: dict[PlanKind, Plan] = dict.fromkeys(PlanKind, ())
        self._position_ned = self._home_ned = ORIGIN
        self._breach: str | None = None
        self._objected: str | None = None  # against the mission; said once
        self.load(parameters)

    def load(self, parameters: Parameters) -> None:
        """Take radii, limits and actions from the parameters."""
        self.flight.load(parameters)
        self.fence.load(parameters)
        self._rtl_type = int(parameters["RTL_TYPE"])
        self._first_max_m = parameters["MIS_DIST_1WP"]
        self._judge_mission()

    @property
    def is_available(self) -> bool:
        """Whether there is a mission that may be flown; in flight, a new one takes its time."""
        settles = not self._commander.landed and self._time_us - self._uploaded_us < SETTLING_US
        return self._may_be_flown and not settles

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
            self._uploaded_us = self._time_us
        if kind is not PlanKind.RALLY:
            self._objected = None
            self._judge_mission()
        return MissionResult.ACCEPTED

    def set_current(self, sequence: int) -> bool:
        """Go to an item; False if there is no such item."""
        if not 0 <= sequence < len(self._plans[PlanKind.MISSION]):
            return False
        self.flight.set_current(sequence)
        return True

    def drain_reached(self) -> list[int]:
        """Hand over the items that were reached since the last call."""
        if not self.flight.reached:
            return []
        reached, self.flight.reached = self.flight.reached, []
        return reached

    @property
    def progress(self) -> MissionProgress:
        """Where the mission stands."""
        flight, commander = self.flight, self._commander
        total = len(self._plans[PlanKind.MISSION])
        in_mission = commander.mode is Mode.MISSION
        if total == 0:
            state = MissionState.NO_MISSION
        elif flight.finished:
            state = MissionState.COMPLETE
        elif in_mission and commander.armed:
            state = MissionState.ACTIVE
        else:
            state = MissionState.PAUSED if flight.started else MissionState.NOT_STARTED
        return MissionProgress(flight.index, total, state, in_mission)

    def watch(self, time_us: int, position_ned: Vector3, home_ned: Vector3) -> bool:
        """Look whether the fence is breached, and say so when it begins."""
        self._time_us, self._position_ned, self._home_ned = time_us, position_ned, home_ned
        breach = self.fence.breach(time_us, position_ned, home_ned)
        begins = breach is not None and self._breach is None
        self._breach = breach
        acts = self.fence.action > 0
        if begins and acts and self._commander.armed:
            self._commander.say(CRITICAL, f"Geofence violation: {breach}")
        return breach is not None and acts

    def permits(self, place_ned: Vector3) -> bool:
        """Whether the fence lets the vehicle be led somewhere; NaN: where it is."""
        x, y, z = (
            here if math.isnan(there) else there
            for there, here in zip(place_ned, self._position_ned, strict=True)
        )
        return self.fence.action == 0 or self.fence.judge((x, y, z), self._home_ned) is None

    def destination(self, position_ned: Vector3, home_ned: Vector3) -> Vector3:
        """Where a return leads."""
        places = rally.places_of(self._plans[PlanKind.RALLY], self._origin, home_ned)
        return rally.destination(position_ned, home_ned, places, self._rtl_type)

    def _take_fence(self, plan: Plan) -> bool:
        """Take a fence, unless the vehicle would be outside of it in flight."""
        self.fence.take(plan)
        if self._commander.landed or self.permits(self._position_ned):
            return True
        self.fence.take(self._plans[PlanKind.FENCE])
        text = "Geofence invalid, doesn't contain current vehicle position"
        self._commander.say(CRITICAL, text)
        return False

    def _judge_mission(self) -> None:
        """Look whether there is a mission, and one that may be flown."""
        plan = self._plans[PlanKind.MISSION]
        objection = self._objection(plan)
        if objection is not None and objection != self._objected:
            self._commander.say(CRITICAL, objection)
        self._objected = objection
        self._may_be_flown = bool(plan) and objection is None
        self._commander.health = self._commander.health._replace(
            mission_available=self.is_available
        )

    def _objection(self, plan: Plan) -> str | None:
        """Say what speaks against a mission: a place out of the fence, or a start far away."""
        places = [
            (n, self._place_of(item)) for n, item in enumerate(plan, 1) if item.command in PLACES
        ]
        for number, place in places:
            if not self.permits(place):
                return f"Geofence violation for waypoint {number}"
        if places and self._first_max_m > 0.0:
            away_m = math.dist(places[0][1][:2], self._position_ned[:2])
            if away_m > self._first_max_m:  # NaN, the place left open, is here
                return f"First waypoint too far away: {away_m:.0f}m, {self._first_max_m:.0f} max"
        return None

    def _place_of(self, item: MissionItem) -> Vector3:
        x, y, z = ned_from_geodetic((item.latitude_deg, item.longitude_deg, item.z), self._origin)
        return (x, y, self._home_ned[2] - item.z if item.frame in RELATIVE_FRAMES else z)
