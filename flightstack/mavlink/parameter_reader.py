"""Read parameters of the vehicle by name, in PX4's bytewise encoding."""

import struct
from collections.abc import Iterable

from pymavlink.dialects.v20 import common

from flightstack.mavlink.link import Link, Message
from flightstack.mavlink_numbers import AUTOPILOT_COMPONENT

Value = int | float
PERIOD_S = 0.5  # wall time between two requests for what has not come
MAX_AT_ONCE = 8  # requests in one datagram: serial lines are slow
BY_NAME = -1
WHOLE = {common.MAV_PARAM_TYPE_INT32: "<i", common.MAV_PARAM_TYPE_UINT32: "<I"}


class ParameterReader:
    """Ask for parameters until they have come; a vehicle says nothing of those it has not."""

    def __init__(self, link: Link, names: Iterable[str]) -> None:
        self.values: dict[str, Value] = {}  # of those that have come
        self._link = link
        self._wanted = list(names)
        self._asked_s: float | None = None
        link.heed(common.MAVLINK_MSG_ID_PARAM_VALUE)

    @property
    def missing(self) -> list[str]:
        """Which have not come, in the order in which they were named."""
        return [name for name in self._wanted if name not in self.values]

    def poll(self) -> None:
        """Ask again, if it is time to."""
        now_s = self._link.clock.wall_s()
        if self._asked_s is not None and now_s - self._asked_s < PERIOD_S:
            return
        self._asked_s = now_s
        for name in self.missing[:MAX_AT_ONCE]:
            self._link.send(
                common.MAVLink_param_request_read_message(
                    self._link.system_id, AUTOPILOT_COMPONENT, name.encode(), BY_NAME
                )
            )

    def take(self, message: Message) -> None:
        """Take a PARAM_VALUE; one that was not asked for passes by."""
        name = str(message.param_id)
        if name in self._wanted:
            self.values[name] = _decode(message)


def _decode(message: Message) -> Value:
    """Return a value: a whole number's four bytes stand where the float's would."""
    form = WHOLE.get(message.param_type)
    if form is None:
        return float(message.param_value)
    return int(struct.unpack(form, struct.pack("<f", message.param_value))[0])
