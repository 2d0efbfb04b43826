"""Begin a mode: complete its goal, lead the navigator there, and tell the pilot."""

import math
from typing import NamedTuple, Self

from sitl.autopilot.command.commander import Commander
from sitl.autopilot.command.missions import Missions
from sitl.autopilot.flight_modes.home import Home
from sitl.autopilot.flight_modes.navigator import Goal, Navigator
from sitl.autopilot.parameters import ParameterValues
from sitl.records.modes import Mode
from sitl.records.motion import Vector3
from sitl.records.sensing import Estimate
from sitl.records.texts import INFO


class EntryParameters(NamedTuple):
    """How high a take-off leads that is told no altitude."""

    takeoff_height_m: float  # MIS_TAKEOFF_ALT, above home

    @classmethod
    def resolve(cls, values: ParameterValues) -> Self:
        """Take PX4's values."""
        return cls(takeoff_height_m=values["MIS_TAKEOFF_ALT"])


class ModeEntry:
    """Knows what each mode needs before its first tick."""

    def __init__(
        self,
        parameters: EntryParameters,
        commander: Commander,
        navigator: Navigator,
        missions: Missions,
        home: Home,
        origin_altitude_m: float,
    ) -> None:
        """Begin modes of that commander; the local origin lies at that altitude AMSL."""
        self.parameters = parameters
        self._commander = commander
        self._navigator = navigator
        self._missions = missions
        self._home = home
        self._origin_altitude_m = origin_altitude_m

    def begin(self, estimate: Estimate, motion: Vector3) -> None:
        """Begin the commander's mode; `motion` is the vehicle's acceleration in flight, m/s2."""
        state, missions = self._commander.state, self._missions
        mode, goal, home = state.mode, state.goal, self._home.position_ned
        if mode is Mode.TAKEOFF:
            goal = self._takeoff_goal(goal, estimate)
        elif mode is Mode.RTL:
            home = missions.destination(estimate.position_ned, home)
            goal = goal._replace(yaw_rad=self._home.yaw_rad)
        elif mode is Mode.MISSION and state.armed:
            missions.flight.start(estimate, home, landed=state.landed)
        self._navigator.enter(mode, goal, home, estimate, motion)
        if mode is Mode.RTL and state.armed:
            height = self._navigator.state.return_home.height_m
            altitude = self._origin_altitude_m - home[2] + height
            self._commander.say(
                INFO,
                f"RTL: start return at {altitude:.0f} m ({height:.0f} m above destination)",
            )

    def _takeoff_goal(self, goal: Goal, estimate: Estimate) -> Goal:
        """Complete a take-off's goal: never below where the vehicle is."""
        x, y, z = goal.position_ned
        down = estimate.position_ned[2]
        if math.isnan(z):
            height = self.parameters.takeoff_height_m
            z = (self._home.known_ned or estimate.position_ned)[2] - height
            if self._commander.state.armed:
                self._commander.say(INFO, f"Using default takeoff altitude: {height:.1f} m")
        return goal._replace(position_ned=(x, y, min(z, down)))
