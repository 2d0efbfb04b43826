"""Watch the ground station's heartbeat, and say when it is lost and found.

never heard --heartbeat--> connected <--heartbeat-- lost
                               `---timeout, vehicle time---^
"""

from sitl.records.texts import INFO, StatusText

LOST = StatusText(severity=INFO, text="Connection to ground station lost")
REGAINED = StatusText(severity=INFO, text="GCS connection regained")


class GroundStationWatch:
    """Follow one vehicle's ground station, whatever link it uses. Times are vehicle time."""

    def __init__(self) -> None:
        self._heard_us: int | None = None
        self._is_lost = False

    def heard(self, time_us: int) -> StatusText | None:
        """Note a heartbeat."""
        was_lost, self._is_lost, self._heard_us = self._is_lost, False, time_us
        return REGAINED if was_lost else None

    def check(self, time_us: int, timeout_s: float) -> StatusText | None:
        """Look whether it has been silent for longer than `timeout_s` (COM_DL_LOSS_T)."""
        if self._heard_us is None or self._is_lost:
            return None
        if time_us - self._heard_us <= timeout_s * 1e6:
            return None
        self._is_lost = True
        return LOST
