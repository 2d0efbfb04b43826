"""Who has been heard, and who has fallen silent: ground station, companion computer, sticks.

unknown --heard--> there --silent for its timeout, vehicle time--> lost --heard--> there
"""

from typing import NamedTuple, Self

from sitl.autopilot.parameters import ParameterValues
from sitl.clock import SECOND_US

STICKS_OVER_MAVLINK = {1, 2, 3}  # COM_RC_IN_MODE


class LinkWatch(NamedTuple):
    """When one sender was last heard; None: never."""

    heard_us: int | None = None

    def is_there(self, time_us: int, timeout_us: int) -> bool:
        """Whether it has been heard within its timeout."""
        return self.heard_us is not None and time_us - self.heard_us < timeout_us

    def is_lost(self, time_us: int, timeout_us: int) -> bool:
        """Whether it was there once, and is no more."""
        return self.heard_us is not None and time_us - self.heard_us >= timeout_us


class LinkParameters(NamedTuple):
    """After how long a silent sender is lost, and whose sticks count."""

    ground_station_timeout_us: int  # COM_DL_LOSS_T
    companion_timeout_us: int  # COM_OBC_LOSS_T
    sticks_timeout_us: int  # COM_RC_LOSS_T
    takes_sticks: bool  # COM_RC_IN_MODE: from MAVLink

    @classmethod
    def resolve(cls, values: ParameterValues) -> Self:
        """Take PX4's values, in SI units."""
        return cls(
            ground_station_timeout_us=round(values["COM_DL_LOSS_T"] * SECOND_US),
            companion_timeout_us=round(values["COM_OBC_LOSS_T"] * SECOND_US),
            sticks_timeout_us=round(values["COM_RC_LOSS_T"] * SECOND_US),
            takes_sticks=int(values["COM_RC_IN_MODE"]) in STICKS_OVER_MAVLINK,
        )
