"""What is flown, and by whom, as the command lines of the two processes: all of it is in them."""

from dataclasses import dataclass
from pathlib import Path

from flightstack.launch.ports import Ports

LAP_LIMIT_S = 90.0  # vehicle time: whoever needs longer has lost the course

GIVES_UP = (
    "--reach=2",
)  # a simulated vehicle that falls silent has ended: nobody has to be reached


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightRequest:
    """One flight, in lockstep: the same seeds give the same flight at any speed."""

    laps: int = 1  # of 8 gates
    track_seed: int = 0
    noise: str = "1.0,2.0"  # of the gates' radius and height in m, as `--noise` takes it
    model: str | None = None  # which flies; None: the companion's default
    strategy: str | None = None  # how it decides; None: the model's
    speed_factor: float = 1.0  # times real time; 0: as fast as possible
    px4: Path | None = None  # a build of a real PX4, or its binary; None: the emulated autopilot
    px4_folder: Path | None = None  # where it runs and leaves its logs; None: nowhere that stays
    vehicle_options: tuple[str, ...] = ()  # further ones of `python -m sitl`
    companion_options: tuple[str, ...] = ()  # further ones of `python -m flightstack.companion`

    def vehicle_arguments(self, ports: Ports) -> list[str]:
        """Return the arguments of `python -m sitl`."""
        return [
            *(() if self.px4 is None else ("--autopilot=px4",)),
            *("--lockstep", f"--speed-factor={self.speed_factor}", *ports.vehicle_options),
            *(f"--laps={self.laps}", f"--track-seed={self.track_seed}", f"--noise={self.noise}"),
            *self.vehicle_options,
        ]

    def companion_arguments(self, ports: Ports) -> list[str]:
        """Return the arguments of `python -m flightstack.companion`."""
        named = {"model": self.model, "strategy": self.strategy}
        return [
            *(f"--udp={ports.companion}", f"--duration={LAP_LIMIT_S * self.laps}"),
            *(f"--{name}={value}" for name, value in named.items() if value is not None),
            *self.companion_options,
        ]
