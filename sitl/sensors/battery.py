"""The battery: a pack that empties while the vehicle is armed, as PX4's simulated one does.

The charge falls linearly, down to a least share at which it stays; the voltage follows it.
"""

from typing import NamedTuple

from sitl.clock import SECOND_US


class Pack(NamedTuple):
    """What the parameters say about the battery."""

    cells: int  # BAT1_N_CELLS
    full_v: float  # BAT1_V_CHARGED, a cell
    empty_v: float  # BAT1_V_EMPTY, a cell
    drain_s: float  # SIM_BAT_DRAIN, full to empty
    least: float  # SIM_BAT_MIN_PCT, 0..1


class Battery:
    """Keeps the charge that is left."""

    def __init__(self) -> None:
        self.remaining = 1.0
        self.is_dead = False  # a failure: it counts as empty

    def advance(self, elapsed_us: int, pack: Pack, *, armed: bool) -> None:
        """Discharge for a while."""
        if self.is_dead:
            self.remaining = 0.0
        elif armed and self.remaining > pack.least:
            spent = elapsed_us / SECOND_US / pack.drain_s
            self.remaining = max(pack.least, self.remaining - spent)

    def voltage_v(self, pack: Pack) -> float:
        """Give the voltage of the whole pack."""
        return pack.cells * (pack.empty_v + self.remaining * (pack.full_v - pack.empty_v))
