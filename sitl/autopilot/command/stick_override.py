"""Let the pilot take over by moving the sticks, where COM_RC_OVERRIDE allows it."""

import math
from typing import NamedTuple, Self

from sitl.autopilot.command.checks import can_run
from sitl.autopilot.command.commander import Commander
from sitl.autopilot.command.mode_table import MODES
from sitl.autopilot.parameters import ParameterValues
from sitl.records.modes import Mode
from sitl.records.texts import INFO
from sitl.records.vehicle import Sticks

SETTLING_US = 1_000_000  # assumption: sticks that rest for longer have a new centre


class OverrideParameters(NamedTuple):
    """Which modes moved sticks end, and how far they have to move."""

    allowed_bits: int  # COM_RC_OVERRIDE
    threshold: float  # COM_RC_STICK_OV, as a share of the full travel

    @classmethod
    def resolve(cls, values: ParameterValues) -> Self:
        """Take PX4's values."""
        return cls(
            allowed_bits=int(values["COM_RC_OVERRIDE"]),
            threshold=values["COM_RC_STICK_OV"] / 100.0,
        )


class SticksAtRest(NamedTuple):
    """Where the sticks have their centre, slowly followed."""

    time_us: int
    axes: tuple[float, float, float, float]


class StickOverride:
    """Knows where the sticks rested, and whether they have moved from there."""

    def __init__(self, parameters: OverrideParameters) -> None:
        self.parameters = parameters
        self._rest: SticksAtRest | None = None

    def moves(self, sticks: Sticks) -> bool:
        """Whether the sticks have moved, by a share of their full travel, within some second."""
        axes = (sticks.forward, sticks.right, sticks.up, sticks.turn)
        rest = self._rest
        if rest is None or sticks.time_us - rest.time_us > SETTLING_US:  # just switched on
            rest = SticksAtRest(sticks.time_us, axes)
        gain = 1.0 - math.exp(-(sticks.time_us - rest.time_us) / SETTLING_US)
        moved = max(abs(a - b) for a, b in zip(axes, rest.axes, strict=True))
        a, b, c, d = (old + gain * (new - old) for new, old in zip(axes, rest.axes, strict=True))
        self._rest = SticksAtRest(sticks.time_us, (a, b, c, d))
        return moved > self.parameters.threshold

    def take_over(self, commander: Commander) -> None:
        """Give the vehicle to the pilot: Position, or Altitude where nobody knows the place."""
        state = commander.state
        allowed = MODES[state.intended].override_bit & self.parameters.allowed_bits
        if not (state.armed and allowed):
            return
        for mode in (Mode.POSCTL, Mode.ALTCTL):
            if can_run(mode, commander.health):
                commander.switch(mode)
                commander.say(INFO, "Pilot took over using sticks")
                return
