"""Answer SETUP_SIGNING: take, change or remove the signing key.

By PX4's rules: the first may come unsigned, later ones must be signed (what is not never gets
here), a key of zeros ends signing, and nothing changes while the vehicle is armed.
"""

import logging

from sitl.mavlink.links.link import Guard
from sitl.mavlink.servers.request import Request
from sitl.mavlink.vehicle import SimulatedVehicle
from sitl.mavlink.wire.dialect import Message
from sitl.mavlink.wire.refusals import Refusal

_log = logging.getLogger(__name__)


class SigningServer:
    """Hand a new key to the links."""

    def __init__(self, vehicle: SimulatedVehicle, guard: Guard) -> None:
        self._vehicle = vehicle
        self._guard = guard

    def set_up(self, message: Message, request: Request) -> None:
        """Take over the key, unless armed. There is no answer: the next packets are signed."""
        if self._vehicle.autopilot.status.armed:
            self._guard.refusals.note([Refusal.KEY_CHANGE])
            return
        self._guard.signing.set_up(bytes(message.secret_key), message.initial_timestamp)
        change = "set" if self._guard.signing.is_on else "removed"
        _log.info("signing key %s by %d/%d", change, request.system, request.component)
