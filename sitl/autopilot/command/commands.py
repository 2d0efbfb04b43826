"""MAVLink commands to the autopilot: each becomes an action of the commander and a result."""

import math
from collections.abc import Callable, Mapping

from sitl.autopilot.command.commander import Commander
from sitl.autopilot.command.failure_commands import FailureCommands
from sitl.autopilot.command.mission_commands import MissionCommands
from sitl.autopilot.command.missions import Missions
from sitl.autopilot.flight_modes.mission_plan import (
    ALTITUDE_MAX_M,
    LATITUDE_MAX_DEG,
    LONGITUDE_MAX_DEG,
)
from sitl.autopilot.flight_modes.navigator import Goal, Navigator
from sitl.frames import ned_from_geodetic
from sitl.records.modes import Mode, mode_of
from sitl.records.motion import Vector3
from sitl.records.texts import CRITICAL, INFO
from sitl.records.vehicle import Command, CommandResult

# MAV_CMD
NAV_RETURN_TO_LAUNCH, NAV_LAND, NAV_TAKEOFF = 20, 21, 22
DO_SET_MODE, DO_SET_HOME, DO_FLIGHTTERMINATION, DO_REPOSITION = 176, 179, 185, 192
PREFLIGHT_REBOOT_SHUTDOWN, COMPONENT_ARM_DISARM = 246, 400

# MAV_RESULT
ACCEPTED, TEMPORARILY_REJECTED, DENIED, UNSUPPORTED = 0, 1, 2, 3

FORCE = 21196.0  # COMPONENT_ARM_DISARM.param2
CUSTOM_MODE = 1  # MAV_MODE_FLAG_CUSTOM_MODE_ENABLED
CHANGE_MODE = 1  # MAV_DO_REPOSITION_FLAGS_CHANGE_MODE
RELATIVE_FRAMES = {3, 6}  # MAV_FRAME_GLOBAL_RELATIVE_ALT, and its _INT twin
NAN = math.nan

Handler = Callable[[Command], int | None]


class Commands:
    """Obeys commands; where a handler gives no result, PX4 stays silent."""

    def __init__(
        self,
        commander: Commander,
        missions: Missions,
        navigator: Navigator,
        failures: FailureCommands,
        home: Vector3,
    ) -> None:
        self._commander = commander
        self._missions = missions
        self._home = home  # latitude deg, longitude deg, altitude m of the local origin
        self._home_request: Vector3 | None = None  # local NED, NaN for the present position
        self._handlers: Mapping[int, Handler] = {
            NAV_RETURN_TO_LAUNCH: lambda _: self._switch(Mode.RTL),
            NAV_LAND: self._land,
            NAV_TAKEOFF: self._take_off,
            DO_SET_MODE: self._do_set_mode,
            DO_SET_HOME: self._set_home,
            DO_FLIGHTTERMINATION: self._terminate,
            DO_REPOSITION: self._reposition,
            PREFLIGHT_REBOOT_SHUTDOWN: lambda _: DENIED,  # a process is restarted from outside
            COMPONENT_ARM_DISARM: self._arm_or_disarm,
            **MissionCommands(commander, missions, navigator).handlers,
            **failures.handlers,
        }

    def handle(self, command: Command) -> CommandResult | None:
        """Obey or refuse a command."""
        handler = self._handlers.get(command.command)
        result = UNSUPPORTED if handler is None else handler(command)
        return None if result is None else CommandResult(result=result)

    def take_home_request(self) -> Vector3 | None:
        """Take where home is to be, if a command has put it there since the last call."""
        place, self._home_request = self._home_request, None
        return place

    def set_mode(self, main: int, sub: int) -> CommandResult:
        """Switch by PX4's numbers; unknown ones are accepted and change nothing, as PX4 does."""
        mode = mode_of(main, sub)
        return CommandResult(result=ACCEPTED if mode is None else self._switch(mode))

    def _switch(self, mode: Mode, goal: Goal | None = None) -> int:
        return ACCEPTED if self._commander.switch(mode, goal) else TEMPORARILY_REJECTED

    def _do_set_mode(self, command: Command) -> int:
        base, main, sub = (_whole(value) for value in command.params[:3])
        if not base & CUSTOM_MODE:
            return ACCEPTED
        return self.set_mode(main, sub).result

    def _arm_or_disarm(self, command: Command) -> int | None:
        wanted, force = command.params[0], command.params[1] == FORCE
        if wanted == 1.0:
            return ACCEPTED if self._commander.arm() else TEMPORARILY_REJECTED
        if wanted == 0.0:
            return ACCEPTED if self._commander.disarm(force=force) else TEMPORARILY_REJECTED
        self._commander.say(CRITICAL, f"Unsupported ARM_DISARM param: {wanted:.3f}")
        return None

    def _land(self, _: Command) -> int:
        result = self._switch(Mode.LAND)
        if result == ACCEPTED and self._commander.state.armed:
            self._commander.say(INFO, "Landing at current position")
        return result

    def _take_off(self, command: Command) -> int:
        if _is_beyond_earth(command):
            return DENIED
        x, y, z = self._place(command)
        return self._switch(Mode.TAKEOFF, Goal((x, y, z), command.params[3]))

    def _reposition(self, command: Command) -> int:
        if not _whole(command.params[1]) & CHANGE_MODE:
            return UNSUPPORTED
        if _is_beyond_earth(command):
            return DENIED
        place = self._place(command)
        if not self._missions.permits(place):
            self._commander.say(CRITICAL, "Reposition is outside geofence")
            return DENIED
        speed = command.params[0] if command.params[0] > 0.0 else NAN
        return self._switch(Mode.HOLD, Goal(place, command.params[3], speed))

    def _terminate(self, command: Command) -> int:
        if not self._commander.state.armed:
            return DENIED
        if command.params[0] > 0.5:
            self._commander.terminate()
        return ACCEPTED

    def _set_home(self, command: Command) -> int:
        here = command.params[0] == 1.0
        place = (NAN, NAN, NAN) if here else self._place(command)
        if not here and (_is_beyond_earth(command) or any(math.isnan(number) for number in place)):
            return DENIED
        self._home_request = place
        return ACCEPTED

    def _place(self, command: Command) -> Vector3:
        """Local NED of a command's latitude, longitude, altitude (AMSL); NaN where not given."""
        latitude, longitude, altitude = command.params[4:]
        if command.frame in RELATIVE_FRAMES:
            altitude += self._home[2]
        x, y, z = ned_from_geodetic((latitude, longitude, altitude), self._home)
        if math.isnan(x) or math.isnan(y):  # half a place is none
            x = y = NAN
        return (x, y, z)


def _is_beyond_earth(command: Command) -> bool:
    """Whether latitude, longitude or altitude can't be; what is not given can."""
    return any(
        abs(number) > limit
        for number, limit in zip(
            command.params[4:], (LATITUDE_MAX_DEG, LONGITUDE_MAX_DEG, ALTITUDE_MAX_M), strict=True
        )
    )


def _whole(value: float) -> int:
    return int(value) if math.isfinite(value) else 0
