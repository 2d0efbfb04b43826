"""Serve the parameters: list, read, set, in PX4's bytewise encoding."""

import struct
from collections.abc import Callable

from sitl.clock import SECOND_US
from sitl.errors import UsageError
from sitl.mavlink.servers.request import Outlet, Request
from sitl.mavlink.vehicle import ParameterStore
from sitl.mavlink.wire.crc32 import crc32
from sitl.mavlink.wire.dialect import Message, mavlink
from sitl.mavlink.wire.packets import Packed
from sitl.mavlink.wire.refusals import Refusal, Refusals

HASH_NAME = "_HASH_CHECK"  # PX4's checksum of all parameters, first of every list
HASH_INDEX = 65535
INT32, UINT32, REAL32 = 6, 5, 9  # MAV_PARAM_TYPE
LIST_RATE_HZ = 950  # as PX4 lists them
MAX_BURST = 16  # parameters in one call, however long it was ago
PARAM_VALUE = struct.Struct("<4sHH16sB")  # the value as bytes: a float would not keep every int


class ParameterServer:
    """Answer the parameter protocol; lists go out at PX4's pace, one at a time for each link."""

    def __init__(
        self,
        parameters: ParameterStore,
        broadcast: Callable[[Packed], None],
        refusals: Refusals | None = None,
    ) -> None:
        """Serve a table; `broadcast` tells a change on all links."""
        self._refusals = refusals or Refusals()
        self._parameters = parameters
        self._broadcast = broadcast  # every change is told on all links
        self._names = parameters.names()
        self._lists: dict[Outlet, int] = {}  # the index that goes next
        self._last_us = 0

    @property
    def is_listing(self) -> bool:
        """Whether a list is under way."""
        return bool(self._lists)

    def request_list(self, _message: Message, request: Request) -> None:
        """Begin to list: PARAM_REQUEST_LIST."""
        request.outlet.send_packed(self._hash_value())
        self._lists[request.outlet] = 0

    def request_read(self, message: Message, request: Request) -> None:
        """Answer PARAM_REQUEST_READ by name or index; silent where there is none, as PX4."""
        outlet = request.outlet
        index = message.param_index
        if index == -1 and message.param_id == HASH_NAME:
            outlet.send_packed(self._hash_value())
        elif index == -1 and message.param_id in self._parameters:
            outlet.send_packed(self._value(self._names.index(message.param_id)))
        elif 0 <= index < len(self._names):
            outlet.send_packed(self._value(index))

    def set(self, message: Message, request: Request) -> None:
        """Answer PARAM_SET: the value kept goes to all links; unknown or mistyped: silence."""
        name = message.param_id
        if name == HASH_NAME:  # the ground station knows them all: the list may end
            self._lists.pop(request.outlet, None)
            return
        if name not in self._parameters or message.param_type != self._parameters.type_of(name):
            self._refusals.note([Refusal.PARAMETER])
            return
        try:
            self._parameters.set(name, _decode(message.param_value, message.param_type))
        except UsageError:  # the echo shows the value that stays
            self._refusals.note([Refusal.PARAMETER])
        self._broadcast(self._value(self._names.index(name)))

    def advance(self, elapsed_us: int) -> None:
        """Send what is due of the lists under way, `elapsed_us` after the last call."""
        count = min(MAX_BURST, max(1, elapsed_us * LIST_RATE_HZ // SECOND_US))
        for outlet, index in list(self._lists.items()):
            end = min(index + count, len(self._names))
            for number in range(index, end):
                outlet.send_packed(self._value(number))
            if end < len(self._names):
                self._lists[outlet] = end
            else:
                del self._lists[outlet]

    def _value(self, index: int) -> Packed:
        name = self._names[index]
        kind = self._parameters.type_of(name)
        value = _value_bytes(self._parameters.get(name), kind)
        return self._pack(name, value, kind, index)

    def _hash_value(self) -> Packed:
        state = 0
        for name in self._names:
            value = self._parameters.get(name)
            kind = self._parameters.type_of(name)
            state = crc32(name.encode() + _value_bytes(value, kind), state)
        return self._pack(HASH_NAME, struct.pack("<I", state), UINT32, HASH_INDEX)

    def _pack(self, name: str, value: bytes, kind: int, index: int) -> Packed:
        payload = PARAM_VALUE.pack(value, len(self._names), index, name.encode(), kind)
        message_type = mavlink.MAVLink_param_value_message
        return Packed(message_type.id, payload, message_type.crc_extra)


def _value_bytes(value: float, kind: int) -> bytes:
    return struct.pack("<i", int(value)) if kind == INT32 else struct.pack("<f", value)


def _decode(field: float, kind: int) -> float:
    if kind == INT32:
        return int(struct.unpack("<i", struct.pack("<f", field))[0])
    return field
