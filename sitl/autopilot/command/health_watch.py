"""Gather what the checks and failsafes look at, and tell the pilot what gets worse."""

from typing import NamedTuple, Self

from sitl.autopilot.command.checks import BatteryLevel, Health
from sitl.autopilot.command.links import LinkParameters, LinkWatch
from sitl.autopilot.flight_modes.offboard import OffboardStream
from sitl.autopilot.parameters import ParameterValues
from sitl.records.sensing import Estimate
from sitl.records.texts import WARNING, StatusText

BATTERY_TEXTS = {
    BatteryLevel.LOW: "Low battery level, return advised",
    BatteryLevel.CRITICAL: "Critical battery level, return now",
    BatteryLevel.EMERGENCY: "Emergency battery level, land immediately",
}
COMPANION_LOST = "Connection to mission computer lost"
COMPANION_BACK = "Connection to mission computer regained"


class HealthParameters(NamedTuple):
    """When a link counts as lost, and a battery as empty: shares of its charge."""

    links: LinkParameters
    emergency_share: float  # BAT_EMERGEN_THR
    critical_share: float  # BAT_CRIT_THR
    low_share: float  # BAT_LOW_THR

    @classmethod
    def resolve(cls, values: ParameterValues) -> Self:
        """Take PX4's values."""
        return cls(
            links=LinkParameters.resolve(values),
            emergency_share=values["BAT_EMERGEN_THR"],
            critical_share=values["BAT_CRIT_THR"],
            low_share=values["BAT_LOW_THR"],
        )

    def battery_level(self, charge: float) -> BatteryLevel:
        """Say how empty a battery is by its charge, 0..1."""
        if charge < self.emergency_share:
            return BatteryLevel.EMERGENCY
        if charge < self.critical_share:
            return BatteryLevel.CRITICAL
        return BatteryLevel.LOW if charge < self.low_share else BatteryLevel.FINE


class HealthWatch:
    """Follows the links and the battery; the estimator's flags it passes on.

    `health` is what is known now: that of the last tick, and what has come in since.
    """

    def __init__(self, parameters: HealthParameters) -> None:
        self.parameters = parameters
        self.health = Health()
        self._ground_station = self._companion = self._sticks = LinkWatch()
        self._is_companion_lost = False
        self._charge = 1.0
        self._battery = BatteryLevel.FINE
        self._texts: list[StatusText] = []

    def start_airborne(self) -> None:
        """Begin in flight, in OFFBOARD."""
        self.health = Health(
            attitude_valid=True, position_valid=True, altitude_valid=True, offboard_available=True
        )

    def ground_station_heard(self, time_us: int) -> None:
        """Note a ground station's heartbeat."""
        self._ground_station = LinkWatch(time_us)

    def companion_heard(self, time_us: int) -> None:
        """Note a companion computer's heartbeat."""
        self._companion = LinkWatch(time_us)

    def sticks_heard(self, time_us: int) -> None:
        """Note the sticks; their modes may be chosen right after."""
        self._sticks = LinkWatch(time_us)
        if not self.health.sticks_available:
            self.health = self.health._replace(sticks_available=True)

    def setpoint_heard(self, *, by_attitude: bool) -> None:
        """Note an offboard setpoint; OFFBOARD may be chosen right after."""
        health = self.health
        if not health.offboard_available or health.offboard_by_attitude is not by_attitude:
            self.health = health._replace(offboard_available=True, offboard_by_attitude=by_attitude)

    def mission_judged(self, *, is_available: bool) -> None:
        """Note whether there is a mission that may be flown."""
        if self.health.mission_available is not is_available:
            self.health = self.health._replace(mission_available=is_available)

    def armed(self, time_us: int) -> None:
        """Count sticks that are lost at arming as not needed, until they come back."""
        if self._sticks.is_lost(time_us, self.parameters.links.sticks_timeout_us):
            self._sticks = LinkWatch()

    def update(
        self,
        estimate: Estimate,
        offboard: OffboardStream,
        *,
        mission_available: bool,
        mission_failed: bool,
        fence_breached: bool,
    ) -> None:
        """Look at everything once a tick."""
        time_us, links = estimate.time_us, self.parameters.links
        if estimate.battery != self._charge:
            self._charge = estimate.battery
            self.judge_battery()
        if self._companion.heard_us is not None:
            self._watch_companion(time_us)
        sticks = self._sticks
        takes_sticks = links.takes_sticks and sticks.heard_us is not None
        now = (
            estimate.attitude_valid,
            estimate.position_valid,
            estimate.altitude_valid,
            offboard.is_alive(time_us),
            offboard.attitude is not None,
            takes_sticks and sticks.is_there(time_us, links.sticks_timeout_us),
            takes_sticks and sticks.is_lost(time_us, links.sticks_timeout_us),
            self._ground_station.is_lost(time_us, links.ground_station_timeout_us),
            mission_available,
            mission_failed,
            fence_breached,
            self._battery,
            estimate.sensors,
            estimate.settled,
        )
        if now != self.health:  # the same object while nothing changes, which is quickly compared
            self.health = Health(*now)

    def drain_texts(self) -> list[StatusText]:
        """Take the texts that came up since the last call."""
        texts, self._texts = self._texts, []
        return texts

    def judge_battery(self) -> None:
        """Look how empty the battery is by the parameters, and say so where that is worse."""
        level = self.parameters.battery_level(self._charge)
        if level > self._battery:
            self._say(BATTERY_TEXTS[level])
        self._battery = level

    def _watch_companion(self, time_us: int) -> None:
        """Tell once when the companion computer is lost, and when it is back."""
        is_lost = self._companion.is_lost(time_us, self.parameters.links.companion_timeout_us)
        if is_lost is not self._is_companion_lost:
            self._is_companion_lost = is_lost
            self._say(COMPANION_LOST if is_lost else COMPANION_BACK)

    def _say(self, text: str) -> None:
        self._texts.append(StatusText(severity=WARNING, text=text + "\t"))
