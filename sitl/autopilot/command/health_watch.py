"""Gather what the checks and failsafes look at, and tell the pilot what gets worse."""

from sitl.autopilot.command.checks import Battery, Health
from sitl.autopilot.command.links import Links
from sitl.autopilot.flight_modes.offboard import OffboardStream
from sitl.autopilot.parameters import Parameters
from sitl.records.sensing import Estimate
from sitl.records.texts import WARNING, StatusText

BATTERY_TEXTS = {
    Battery.LOW: "Low battery level, return advised",
    Battery.CRITICAL: "Critical battery level, return now",
    Battery.EMERGENCY: "Emergency battery level, land immediately",
}


class HealthWatch:
    """Follows the links and the battery; the estimator's flags it passes on."""

    def __init__(self, parameters: Parameters) -> None:
        self.links = Links(parameters)
        self._battery = Battery.FINE
        self._charge = 1.0
        self._health = Health()
        self._texts: list[StatusText] = []
        self.load(parameters)

    def load(self, parameters: Parameters) -> None:
        """Take timeouts and thresholds from the parameters."""
        p = parameters
        self.links.load(parameters)
        self._thresholds = (
            (p["BAT_EMERGEN_THR"], Battery.EMERGENCY),
            (p["BAT_CRIT_THR"], Battery.CRITICAL),
            (p["BAT_LOW_THR"], Battery.LOW),
        )
        self._highest = max(threshold for threshold, _ in self._thresholds)
        self._watch_battery(self._charge)

    def update(
        self,
        estimate: Estimate,
        offboard: OffboardStream,
        *,
        mission_available: bool,
        mission_failed: bool,
        fence_breached: bool,
    ) -> Health:
        """Look at everything once a tick."""
        time_us, links = estimate.time_us, self.links
        if estimate.battery != self._charge:
            self._watch_battery(estimate.battery)
        if links.companion.was_heard:
            self._watch_companion(time_us)
        takes_sticks = links.takes_sticks and links.sticks.was_heard
        now = (
            estimate.attitude_valid,
            estimate.position_valid,
            estimate.altitude_valid,
            offboard.is_alive(time_us),
            offboard.attitude is not None,
            takes_sticks and links.sticks.is_there(time_us),
            takes_sticks and links.sticks.is_lost(time_us),
            links.ground_station.is_lost(time_us),
            mission_available,
            mission_failed,
            fence_breached,
            self._battery,
            estimate.sensors,
            estimate.settled,
        )
        if now != self._health:  # the same object while nothing changes: see the commander
            self._health = Health(*now)
        return self._health

    def drain_texts(self) -> list[StatusText]:
        """Take the texts that came up since the last call."""
        texts, self._texts = self._texts, []
        return texts

    def _watch_battery(self, remaining: float) -> None:
        self._charge = remaining
        if remaining >= self._highest and self._battery is Battery.FINE:
            return
        level = Battery.FINE
        for threshold, name in self._thresholds:
            if remaining < threshold:
                level = name
                break
        if level > self._battery:
            self._texts.append(StatusText(severity=WARNING, text=BATTERY_TEXTS[level] + "\t"))
        self._battery = level

    def _watch_companion(self, time_us: int) -> None:
        news = self.links.companion_news(time_us)
        if news is not None:
            self._texts.append(StatusText(severity=WARNING, text=news + "\t"))
