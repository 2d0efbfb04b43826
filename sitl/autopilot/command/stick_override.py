"""Let the pilot take over by moving the sticks, where COM_RC_OVERRIDE allows it."""

import math

from sitl.autopilot.command.checks import can_run
from sitl.autopilot.command.commander import Commander
from sitl.autopilot.parameters import Parameters
from sitl.records.modes import Mode
from sitl.records.texts import INFO
from sitl.records.vehicle import Sticks

IN_AUTO, IN_OFFBOARD = 1, 2  # bits of COM_RC_OVERRIDE
AUTO = {Mode.TAKEOFF, Mode.HOLD, Mode.MISSION, Mode.RTL, Mode.LAND, Mode.FOLLOW, Mode.PRECLAND}
SETTLING_US = 1_000_000  # assumption: sticks that rest for longer have a new centre


class StickOverride:
    """Knows where the sticks rested, and whether they have moved from there."""

    def __init__(self, parameters: Parameters) -> None:
        self._rest: tuple[float, ...] | None = None
        self._time_us = 0
        self.load(parameters)

    def load(self, parameters: Parameters) -> None:
        """Take what is allowed, and how far the sticks have to move, from the parameters."""
        self._allowed = int(parameters["COM_RC_OVERRIDE"])
        self._threshold = parameters["COM_RC_STICK_OV"] / 100.0

    def moves(self, sticks: Sticks) -> bool:
        """Whether the sticks have moved, by a share of their full travel, within some second."""
        axes = (sticks.forward, sticks.right, sticks.up, sticks.turn)
        elapsed_us, self._time_us = sticks.time_us - self._time_us, sticks.time_us
        if self._rest is None or elapsed_us > SETTLING_US:  # they were just switched on
            self._rest = axes
        gain = 1.0 - math.exp(-elapsed_us / SETTLING_US)
        moved = max(abs(a - b) for a, b in zip(axes, self._rest, strict=True))
        self._rest = tuple(b + gain * (a - b) for a, b in zip(axes, self._rest, strict=True))
        return moved > self._threshold

    def take_over(self, commander: Commander) -> None:
        """Give the vehicle to the pilot: Position, or Altitude where nobody knows the place."""
        if not (commander.armed and self._may_end(commander.intended)):
            return
        for mode in (Mode.POSCTL, Mode.ALTCTL):
            if can_run(mode, commander.health):
                commander.switch(mode)
                commander.say(INFO, "Pilot took over using sticks")
                return

    def _may_end(self, mode: Mode) -> bool:
        if mode is Mode.OFFBOARD:
            return bool(self._allowed & IN_OFFBOARD)
        return mode in AUTO and bool(self._allowed & IN_AUTO)
