"""Send the companion's heartbeat: once a second of vehicle time, and of wall time.

Both, because the vehicle's clock may run fast, and may stand still while the vehicle waits for us.
The wall's turn comes a little later, so that where images come, their stamps alone set the pace.
"""

from collections.abc import Callable

from pymavlink.dialects.v20 import common

from flightstack.mavlink.link import Message

PERIOD_US = 1_000_000
WALL_PERIOD_S = 1.2


class HeartbeatSender:
    """Announce an onboard computer that is part of the vehicle's system."""

    def __init__(self, send: Callable[[Message], None], wall_s: Callable[[], float]) -> None:
        self._send = send
        self._wall_s = wall_s
        self._sent: tuple[int, float] | None = None  # vehicle time us, wall time s

    def send_if_due(self, vehicle_us: int) -> None:
        """Send, if a period has passed on either clock since the last."""
        wall_s = self._wall_s()
        if self._sent is not None:
            sent_us, sent_s = self._sent
            if abs(vehicle_us - sent_us) < PERIOD_US and wall_s - sent_s < WALL_PERIOD_S:
                return
        self._sent = (vehicle_us, wall_s)
        self._send(
            common.MAVLink_heartbeat_message(
                type=common.MAV_TYPE_ONBOARD_CONTROLLER,
                autopilot=common.MAV_AUTOPILOT_INVALID,
                base_mode=0,
                custom_mode=0,
                system_status=common.MAV_STATE_ACTIVE,
                mavlink_version=3,
            )
        )
