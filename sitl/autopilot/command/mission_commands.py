"""MAVLink commands about missions and the way of flying: start, pause, go to an item, speed."""

from collections.abc import Callable, Mapping
from math import isnan

from sitl.autopilot.command.commander import Commander
from sitl.autopilot.command.missions import Missions
from sitl.autopilot.flight_modes.navigator import Navigator
from sitl.records.missions import PlanKind
from sitl.records.modes import Mode
from sitl.records.texts import CRITICAL
from sitl.records.vehicle import Command

# MAV_CMD
DO_CHANGE_SPEED, DO_PAUSE_CONTINUE, DO_SET_MISSION_CURRENT, MISSION_START = 178, 193, 224, 300

ACCEPTED, TEMPORARILY_REJECTED, DENIED = 0, 1, 2  # MAV_RESULT
PAUSE, CONTINUE = 0.0, 1.0  # DO_PAUSE_CONTINUE.param1
GROUND_SPEEDS = {0.0, 1.0}  # SPEED_TYPE: a multicopter takes air speed for ground speed
SPEED_MAX_M_S = 100.0


class MissionCommands:
    """Obeys what concerns the mission."""

    def __init__(self, commander: Commander, missions: Missions, navigator: Navigator) -> None:
        self._commander = commander
        self._missions = missions
        self._navigator = navigator
        self.handlers: Mapping[int, Callable[[Command], int]] = {
            DO_CHANGE_SPEED: self._change_speed,
            DO_PAUSE_CONTINUE: self._pause_or_continue,
            DO_SET_MISSION_CURRENT: self._set_current,
            MISSION_START: self._start,
        }

    def _start(self, command: Command) -> int:
        """Arm and fly the mission, from item param1 on where that is given."""
        first, total = command.params[0], len(self._missions.plan(PlanKind.MISSION))
        if not self._missions.is_available:
            self._commander.say(CRITICAL, "Mission start denied! No valid mission")
            return DENIED
        if not (isnan(first) or -1.0 <= first < total):
            return DENIED
        if first > 0.0:
            self._missions.set_current(int(first))
        if not self._commander.switch(Mode.MISSION):
            return TEMPORARILY_REJECTED
        armed = self._commander.arm("Armed by mission start")
        return ACCEPTED if armed else TEMPORARILY_REJECTED

    def _pause_or_continue(self, command: Command) -> int:
        wanted = command.params[0]
        if wanted not in (PAUSE, CONTINUE):
            return DENIED
        mode = Mode.HOLD if wanted == PAUSE else Mode.MISSION
        if mode is Mode.MISSION and not self._missions.is_available:
            return DENIED
        return ACCEPTED if self._commander.switch(mode) else TEMPORARILY_REJECTED

    def _set_current(self, command: Command) -> int:
        """Go to item param1; param2 asks for a mission to begin anew, which going does anyway."""
        wanted = command.params[0]
        if isnan(wanted) or abs(wanted) > 0xFFFF:
            return DENIED
        return ACCEPTED if self._missions.set_current(int(wanted)) else DENIED

    def _change_speed(self, command: Command) -> int:
        kind, speed = command.params[:2]
        if kind not in GROUND_SPEEDS or isnan(speed) or abs(speed) > SPEED_MAX_M_S:
            return DENIED
        self._navigator.change_speed(speed)
        return ACCEPTED
