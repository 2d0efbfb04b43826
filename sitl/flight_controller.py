"""The seam between the simulation and whoever flies: an estimate in, motor commands out.

The simulation knows no more of a flight controller than this. Today `sitl.autopilot` stands here;
another autopilot may, such as a real PX4 over its HIL interface. Time is that of the estimates.
"""

from typing import Protocol

from sitl.mavlink.vehicle import CommandedAutopilot
from sitl.records.failures import Failure
from sitl.records.motion import MotorThrusts
from sitl.records.sensing import Estimate


class FlightController(CommandedAutopilot, Protocol):
    """Flies one vehicle, a tick at a time; over the wire it is talked to as any autopilot."""

    def step(self, estimate: Estimate) -> MotorThrusts:
        """Advance by one tick of 4 ms and give the rotor thrusts, 0..1, for it."""

    def start_airborne(self) -> None:
        """Begin in the air, armed, in OFFBOARD, hovering: for training, never for a flight."""

    def drain_failures(self) -> list[Failure]:
        """Hand over the failures that were asked for since the last call, to be simulated."""

    @property
    def armed(self) -> bool:
        """Whether the rotors may turn: they shake the sensors and drain the battery."""
