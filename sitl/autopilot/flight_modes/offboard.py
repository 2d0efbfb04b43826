"""The stream of offboard setpoints: is it alive, and what does it ask for now."""

from math import isnan
from typing import NamedTuple, Self

from sitl.autopilot.control.heading import Heading, HeadingParameters
from sitl.autopilot.control.setpoint import Setpoint
from sitl.autopilot.parameters import ParameterValues
from sitl.clock import SECOND_US, TICK_US
from sitl.records.vehicle import AttitudeTarget, OffboardSetpoint

LAST_GOOD_US = 200_000  # PX4 keeps the last good setpoint this long before it stops
LATENCY_US = 4_000  # PX4 was seen to act on a message after 1 to 16 ms; a tick waits as well
STOP = Setpoint(velocity_ned=(0.0, 0.0, 0.0))


class OffboardParameters(NamedTuple):
    """How long a stream may pause, and how briskly its heading turns."""

    timeout_us: int  # COM_OF_LOSS_T
    heading: HeadingParameters

    @classmethod
    def resolve(cls, values: ParameterValues) -> Self:
        """Take PX4's values, in SI units."""
        return cls(
            timeout_us=round(values["COM_OF_LOSS_T"] * SECOND_US),
            heading=HeadingParameters.resolve(values),
        )


class OffboardStream:
    """Keeps the newest setpoint, and the newest that can be flown."""

    def __init__(self, parameters: OffboardParameters) -> None:
        self.parameters = parameters
        self._newest_us: int | None = None
        self._good = STOP
        self._next: tuple[int, Setpoint] | None = None  # when it takes effect
        self._heading = Heading()
        self._turned_us = -1  # when the heading was last led
        self._stop_at_us: int | None = None  # where the newest can't be flown
        self._held_yaw_rad: float | None = None
        self.attitude: AttitudeTarget | None = None  # the newest, if it asks for that

    def receive(self, setpoint: OffboardSetpoint) -> None:
        """Take a setpoint in; a stream is alive even where one of them can't be flown."""
        self._newest_us, self.attitude = setpoint.time_us, None
        if _is_complete(setpoint):
            self._stop_at_us = None
            if self._next is not None:
                self._good = self._next[1]
            self._next = (
                setpoint.time_us + LATENCY_US,
                Setpoint(
                    setpoint.position_ned,
                    setpoint.velocity_ned,
                    setpoint.acceleration_ned,
                    setpoint.yaw_rad,
                    setpoint.yaw_rate_rad_s,
                ),
            )
        elif self._stop_at_us is None:
            self._stop_at_us = setpoint.time_us + LAST_GOOD_US

    def receive_attitude(self, setpoint: AttitudeTarget) -> None:
        """Take a setpoint in that asks for an attitude or body rates instead of motion."""
        self._newest_us, self.attitude = setpoint.time_us, setpoint
        self._good, self._next, self._stop_at_us = STOP, None, None

    @property
    def by_attitude(self) -> bool:
        """Whether the newest setpoint asks for an attitude or rates, which need no position."""
        return self.attitude is not None

    def is_alive(self, time_us: int) -> bool:
        """Whether the newest setpoint is younger than COM_OF_LOSS_T."""
        return (
            self._newest_us is not None and time_us - self._newest_us < self.parameters.timeout_us
        )

    def wants_climb(self, time_us: int, down_m: float) -> bool:
        """Whether the stream asks a vehicle on the ground, at `down_m`, to take off."""
        good = self._flyable(time_us)
        return good.velocity_ned[2] < 0.0 or good.position_ned[2] < down_m

    def setpoint(self, time_us: int, yaw_rad: float) -> Setpoint:
        """Give what to fly now: the newest setpoint, or a stop where it makes no sense.

        Where neither yaw nor yaw rate is asked for, the heading at that moment is held.
        """
        good, heading = self._flyable(time_us), self._heading
        if not isnan(good.yaw_rate_rad_s):
            self._held_yaw_rad, self._turned_us = None, -1
            return good
        if time_us - self._turned_us != TICK_US:
            heading = Heading(yaw_rad)
        self._turned_us = time_us
        wanted = good.yaw_rad
        if isnan(wanted):
            if self._held_yaw_rad is None:
                self._held_yaw_rad = yaw_rad
            wanted = self._held_yaw_rad
        else:
            self._held_yaw_rad = None
        heading = self._heading = heading.follow(wanted, self.parameters.heading)
        return good._replace(yaw_rad=heading.yaw_rad, yaw_rate_rad_s=heading.rate_rad_s)

    def _flyable(self, time_us: int) -> Setpoint:
        if self._next is not None and time_us >= self._next[0]:
            self._good, self._next = self._next[1], None
        return self._good if self._stop_at_us is None or time_us < self._stop_at_us else STOP


def _is_complete(setpoint: OffboardSetpoint) -> bool:
    """Each axis needs a number, and x and y need the same kinds."""
    axes = zip(setpoint.position_ned, setpoint.velocity_ned, setpoint.acceleration_ned, strict=True)
    x, y, z = ([isnan(number) for number in axis] for axis in axes)
    return x == y and not all(x) and not all(z)
