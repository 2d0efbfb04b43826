"""Begin a mode: complete its goal, lead the navigator there, and tell the pilot."""

import math

from sitl.autopilot.command.commander import Commander
from sitl.autopilot.command.missions import Missions
from sitl.autopilot.flight_modes.home import Home
from sitl.autopilot.flight_modes.navigator import Goal, Navigator
from sitl.autopilot.parameters import Parameters
from sitl.records.modes import Mode
from sitl.records.motion import Vector3
from sitl.records.sensing import Estimate
from sitl.records.texts import INFO


class ModeEntry:
    """Knows what each mode needs before its first tick."""

    def __init__(
        self,
        parameters: Parameters,
        commander: Commander,
        navigator: Navigator,
        missions: Missions,
        home: Home,
        *,
        altitude_m: float,
    ) -> None:
        """Begin modes of that commander; `altitude_m` AMSL is that of the local origin."""
        self._parameters = parameters
        self._commander = commander
        self._navigator = navigator
        self._missions = missions
        self._home = home
        self._altitude_m = altitude_m

    def begin(self, estimate: Estimate, motion: Vector3) -> None:
        """Begin the commander's mode; `motion` is the vehicle's acceleration in flight, m/s2."""
        commander, missions = self._commander, self._missions
        mode, goal = commander.mode, commander.goal
        home = self._home.position_ned
        if mode is Mode.TAKEOFF:
            goal = self._takeoff_goal(goal, estimate)
        if mode is Mode.RTL:
            home = missions.destination(estimate.position_ned, home)
            goal = goal._replace(yaw_rad=self._home.yaw_rad)
        if mode is Mode.MISSION and commander.armed:
            missions.flight.start(estimate, home, landed=commander.landed)
        self._navigator.enter(mode, goal, home, estimate, motion)
        if mode is Mode.RTL and commander.armed:
            height = self._navigator.return_height_m
            altitude = self._altitude_m - home[2] + height
            commander.say(
                INFO,
                f"RTL: start return at {altitude:.0f} m ({height:.0f} m above destination)",
            )

    def _takeoff_goal(self, goal: Goal, estimate: Estimate) -> Goal:
        """Complete a take-off's goal: never below where the vehicle is."""
        x, y, z = goal.position_ned
        down = estimate.position_ned[2]
        if math.isnan(z):
            height = self._parameters["MIS_TAKEOFF_ALT"]
            z = (self._home.known_ned or estimate.position_ned)[2] - height
            if self._commander.armed:
                self._commander.say(INFO, f"Using default takeoff altitude: {height:.1f} m")
        return goal._replace(position_ned=(x, y, min(z, down)))
