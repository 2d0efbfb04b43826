"""The stream of offboard setpoints: is it alive, and what does it request now."""

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


class StreamState(NamedTuple):
    """The newest message, and what of the stream can be flown."""

    newest_us: int | None = None
    attitude: AttitudeTarget | None = None  # the newest, if it requests that
    good: Setpoint = STOP
    next: Setpoint | None = None  # becomes good
    next_us: int = 0  # when it does
    stop_at_us: int | None = None  # where the newest can't be flown


class TurnState(NamedTuple):
    """How the heading follows the stream."""

    heading: Heading = Heading()
    turned_us: int = -1  # when it was last led
    held_yaw_rad: float | None = None  # while the stream gives none


NOT_TURNED = TurnState()


class OffboardStream:
    """Keeps the newest setpoint, and the newest that can be flown."""

    def __init__(self, parameters: OffboardParameters) -> None:
        self.parameters = parameters
        self._stream = StreamState()
        self._turn = NOT_TURNED

    def receive(self, setpoint: OffboardSetpoint) -> None:
        """Take a setpoint in; a stream is alive even where one of them can't be flown."""
        before, time_us = self._stream, setpoint.time_us
        if _is_complete(setpoint):
            flyable = Setpoint(
                setpoint.position_ned,
                setpoint.velocity_ned,
                setpoint.acceleration_ned,
                setpoint.yaw_rad,
                setpoint.yaw_rate_rad_s,
            )
            good = before.good if before.next is None else before.next
            self._stream = StreamState(time_us, None, good, flyable, time_us + LATENCY_US)
            return
        stop_at_us = before.stop_at_us
        if stop_at_us is None:
            stop_at_us = time_us + LAST_GOOD_US
        self._stream = before._replace(newest_us=time_us, attitude=None, stop_at_us=stop_at_us)

    def receive_attitude(self, setpoint: AttitudeTarget) -> None:
        """Take a setpoint in that requests an attitude or body rates instead of motion."""
        self._stream = StreamState(setpoint.time_us, setpoint)

    @property
    def attitude(self) -> AttitudeTarget | None:
        """The newest setpoint, if it requests an attitude or rates, which need no position."""
        return self._stream.attitude

    def is_alive(self, time_us: int) -> bool:
        """Whether the newest setpoint is younger than COM_OF_LOSS_T."""
        newest_us = self._stream.newest_us
        return newest_us is not None and time_us - newest_us < self.parameters.timeout_us

    def wants_climb(self, time_us: int, down_m: float) -> bool:
        """Whether the stream requests that a vehicle on the ground, at `down_m`, take off."""
        good = self._flyable(time_us)
        return good.velocity_ned[2] < 0.0 or good.position_ned[2] < down_m

    def setpoint(self, time_us: int, yaw_rad: float) -> Setpoint:
        """Give what to fly now: the newest setpoint, or a stop where it makes no sense.

        Where neither yaw nor yaw rate is requested, the heading at that moment is held.
        """
        good = self._flyable(time_us)
        if not isnan(good.yaw_rate_rad_s):
            self._turn = NOT_TURNED
            return good
        heading, turned_us, held = self._turn
        if time_us - turned_us != TICK_US:
            heading = Heading(yaw_rad)
        target = good.yaw_rad
        if isnan(target):
            target = held = yaw_rad if held is None else held
        else:
            held = None
        heading = heading.follow(target, self.parameters.heading)
        self._turn = TurnState(heading, time_us, held)
        position, velocity, acceleration, _, _ = good
        return Setpoint(position, velocity, acceleration, *heading)

    def _flyable(self, time_us: int) -> Setpoint:
        stream = self._stream
        if stream.next is not None and time_us >= stream.next_us:
            stream = self._stream = stream._replace(good=stream.next, next=None)
        if stream.stop_at_us is None or time_us < stream.stop_at_us:
            return stream.good
        return STOP


def _is_complete(setpoint: OffboardSetpoint) -> bool:
    """Each axis needs a number, and x and y need the same kinds."""
    axes = zip(setpoint.position_ned, setpoint.velocity_ned, setpoint.acceleration_ned, strict=True)
    x, y, z = ([isnan(number) for number in axis] for axis in axes)
    return x == y and not all(x) and not all(z)
