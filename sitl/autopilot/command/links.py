"""Who has been heard, and who has fallen silent: ground station, companion computer, sticks.

unknown --heard--> there --silent for its timeout, vehicle time--> lost --heard--> there
"""

from sitl.autopilot.parameters import Parameters
from sitl.clock import SECOND_US

STICKS_OVER_MAVLINK = {1, 2, 3}  # COM_RC_IN_MODE


class Watch:
    """Follows one sender."""

    def __init__(self) -> None:
        self.timeout_us = 0
        self._heard_us: int | None = None

    def heard(self, time_us: int) -> None:
        """Note a message of the sender."""
        self._heard_us = time_us

    @property
    def was_heard(self) -> bool:
        """Whether it has ever been heard."""
        return self._heard_us is not None

    def forget(self) -> None:
        """Be as before it was ever heard."""
        self._heard_us = None

    def is_there(self, time_us: int) -> bool:
        """Whether it has been heard within its timeout."""
        return self._heard_us is not None and time_us - self._heard_us < self.timeout_us

    def is_lost(self, time_us: int) -> bool:
        """Whether it was there once, and is no more."""
        return self._heard_us is not None and time_us - self._heard_us >= self.timeout_us


class Links:
    """The senders that a failsafe or a warning depends on."""

    def __init__(self, parameters: Parameters) -> None:
        self.ground_station = Watch()
        self.companion = Watch()
        self.sticks = Watch()
        self._companion_lost = False
        self.load(parameters)

    def load(self, parameters: Parameters) -> None:
        """Take the timeouts from the parameters."""
        p = parameters
        self.ground_station.timeout_us = round(p["COM_DL_LOSS_T"] * SECOND_US)
        self.companion.timeout_us = round(p["COM_OBC_LOSS_T"] * SECOND_US)
        self.sticks.timeout_us = round(p["COM_RC_LOSS_T"] * SECOND_US)
        self.takes_sticks = int(p["COM_RC_IN_MODE"]) in STICKS_OVER_MAVLINK

    def armed(self, time_us: int) -> None:
        """Count sticks that are lost at arming as not needed, until they come back."""
        if self.sticks.is_lost(time_us):
            self.sticks.forget()

    def companion_news(self, time_us: int) -> str | None:
        """Tell once when the companion computer is lost, and when it is back."""
        lost = self.companion.is_lost(time_us)
        if lost is self._companion_lost:
            return None
        self._companion_lost = lost
        lost_text, back_text = (
            "Connection to mission computer lost",
            "Connection to mission computer regained",
        )
        return lost_text if lost else back_text
