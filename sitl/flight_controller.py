"""The seam between the simulation and whoever flies: sensor readings in, motor commands out.

The simulation knows no more of a flight controller than this. Two stand here: the emulated one
(`sitl.emulated_controller`), and a real PX4 over its simulator interface (`sitl.hil`).
"""

from typing import Protocol

from sitl.records.failures import Failure
from sitl.records.motion import MotorThrusts, VehicleState
from sitl.records.sensing import Readings
from sitl.sensors.battery import Pack


class FlightController(Protocol):
    """Flies one vehicle: hears of each tick at its end, and drives the motors in the next."""

    def sense(self, state: VehicleState, readings: Readings) -> None:
        """Take what the sensors read at `state.time_us`, the end of a tick.

        The true state is for models of an estimate and for ground truth, never to steer by.
        """

    def drive(self) -> MotorThrusts:
        """Give the rotor thrusts, 0..1, for the tick that begins; to be called once for each."""

    def drain_failures(self) -> list[Failure]:
        """Hand over the failures that were asked for since the last call, to be simulated."""

    @property
    def armed(self) -> bool:
        """Whether the rotors may turn: they shake the sensors and drain the battery."""

    @property
    def pack(self) -> Pack:
        """The battery, as the parameters have it now."""
