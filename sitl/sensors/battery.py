"""The battery: a pack that empties while the vehicle is armed, as PX4's simulated one does.

The charge falls linearly, down to a minimum at which it stays; the voltage follows it.
"""

from collections.abc import Mapping
from typing import NamedTuple, Self

from sitl.clock import SECOND_US


class Pack(NamedTuple):
    """What the parameters say about the battery."""

    cells: int  # BAT1_N_CELLS
    full_v: float  # BAT1_V_CHARGED, per cell
    empty_v: float  # BAT1_V_EMPTY, per cell
    drain_s: float  # SIM_BAT_DRAIN, full to empty
    min_charge: float  # SIM_BAT_MIN_PCT, 0..1

    @classmethod
    def resolve(cls, values: Mapping[str, float]) -> Self:
        """Take PX4's parameters."""
        return cls(
            cells=int(values["BAT1_N_CELLS"]),
            full_v=values["BAT1_V_CHARGED"],
            empty_v=values["BAT1_V_EMPTY"],
            drain_s=values["SIM_BAT_DRAIN"],
            min_charge=values["SIM_BAT_MIN_PCT"] / 100.0,
        )

    def voltage_v(self, charge: float) -> float:
        """Give the voltage of the whole pack at a charge."""
        return self.cells * (self.empty_v + charge * (self.full_v - self.empty_v))


class Battery:
    """Keeps the charge that is left."""

    def __init__(self) -> None:
        self.remaining = 1.0

    def advance(self, elapsed_us: int, pack: Pack, *, armed: bool) -> None:
        """Discharge for a while."""
        if armed and self.remaining > pack.min_charge:
            spent = elapsed_us / SECOND_US / pack.drain_s
            self.remaining = max(pack.min_charge, self.remaining - spent)
