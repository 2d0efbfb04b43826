"""Ask whoever leads in the active mode: offboard stream, sticks, or the navigator."""

from sitl.autopilot.command.commander import Commander
from sitl.autopilot.command.missions import Missions
from sitl.autopilot.command.mode_table import Leader
from sitl.autopilot.control.setpoint import Setpoint, level
from sitl.autopilot.flight_modes.manual import Manual
from sitl.autopilot.flight_modes.navigator import Navigator
from sitl.autopilot.flight_modes.offboard import OffboardStream
from sitl.frames import yaw_of
from sitl.records.modes import Mode
from sitl.records.sensing import Estimate


class ModeSetpoints:
    """Gives what to fly now. Without sticks, their modes are led by the navigator."""

    def __init__(
        self,
        commander: Commander,
        missions: Missions,
        navigator: Navigator,
        offboard: OffboardStream,
        manual: Manual,
    ) -> None:
        self._commander = commander
        self._missions = missions
        self._navigator = navigator
        self._offboard = offboard
        self._manual = manual

    def wants_climb(self, estimate: Estimate, *, landed: bool, flying: bool) -> bool:
        """Whether a vehicle that is not flying yet is to take off."""
        leader = self._commander.rules.leader
        if leader is Leader.STREAM:
            return self._offboard.wants_climb(estimate.time_us, estimate.position_ned[2])
        if leader is Leader.STICKS:
            return self._commander.health.sticks_available and self._manual.wants_climb
        if leader is Leader.MISSION:
            flight = self._missions.flight
            return not flying and flight.wants_climb(estimate, landed=landed)
        return self._commander.rules.takes_off

    def now(self, estimate: Estimate, *, in_flight: bool) -> Setpoint:
        """Move whoever leads by one tick."""
        leader = self._commander.rules.leader
        if leader is Leader.STREAM:
            return self._offboard.setpoint(estimate.time_us, yaw_of(estimate.q_ned_frd))
        if leader is Leader.STICKS and self._commander.health.sticks_available:
            manual, mode = self._manual, self._commander.state.mode
            return manual.advance(mode, estimate) if in_flight else manual.wait(estimate)
        if not in_flight:
            return self._navigator.wait(estimate)
        setpoint = self._navigator.advance(estimate)
        if self._navigator.takeoff_done(estimate):
            self._navigator.hold_where_takeoff_leads()
            self._commander.continue_as_hold()
        if leader is Leader.MISSION and self._missions.flight.take_return():
            self._commander.switch(Mode.RTL)
        return setpoint if estimate.position_valid else level(setpoint)
