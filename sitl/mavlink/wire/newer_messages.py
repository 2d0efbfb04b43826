"""MAVLink messages that PX4 and ground stations speak and pymavlink's dialects leave out.

pymavlink ships its message classes ready made, and in 2.4.50 none of its dialects, not `common`,
`development` nor `all`, has COMPONENT_METADATA (397) or the event protocol (410 to 413, of which
this vehicle never sends 410, EVENT itself). PX4 speaks them, so ground stations ask for them. To
generate a dialect of our own would take MAVLink's XML and its generator into the build, for four
small messages. So their classes are made here, from the fields and the CRC_EXTRA that MAVLink
defines, and given to pymavlink's table: then they are packed, read and forwarded like the others.
Once a release of pymavlink has them, this file can go.
"""

import struct
from typing import Any

from sitl.mavlink.wire.dialect import Message, mavlink

TEXT_BYTES = 100  # of the one text there is


def _define(
    number: int, name: str, crc_extra: int, layout: str, fields: tuple[str, ...]
) -> type[Message]:
    """Make a message class; `fields` in the order of the wire, all numbers but a last text."""

    def initialise(self: Message, *values: Any) -> None:
        mavlink.MAVLink_message.__init__(self, number, name)
        self._fieldnames = list(fields)
        for field, value in zip(fields, values, strict=True):
            setattr(self, field, value)

    def pack(self: Message, mav: Any, force_mavlink1: bool = False) -> bytes:  # noqa: FBT001, FBT002
        values = [getattr(self, field) for field in fields]
        payload = self.unpacker.pack(*values)
        return bytes(self._pack(mav, crc_extra, payload, force_mavlink1=force_mavlink1))

    has_text = layout.endswith("s")
    count = len(fields)
    message_type = type(
        f"MAVLink_{name.lower()}_message",
        (mavlink.MAVLink_message,),
        {
            "__init__": initialise,
            "pack": pack,
            "id": number,
            "msgname": name,
            "fieldnames": list(fields),
            "ordered_fieldnames": list(fields),
            "fieldtypes": ["number"] * (count - has_text) + ["char"] * has_text,
            "orders": list(range(count)),
            "lengths": [1] * count,
            "native_format": bytearray(layout.replace(f"{TEXT_BYTES}s", "c"), "ascii"),
            "array_lengths": [0] * (count - has_text) + [TEXT_BYTES] * has_text,
            "crc_extra": crc_extra,
            "unpacker": struct.Struct(layout),
        },
    )
    mavlink.mavlink_map[number] = message_type
    return message_type


ComponentMetadata = _define(
    397, "COMPONENT_METADATA", 182, f"<II{TEXT_BYTES}s", ("time_boot_ms", "file_crc", "uri")
)
CurrentEventSequence = _define(411, "CURRENT_EVENT_SEQUENCE", 106, "<HB", ("sequence", "flags"))
RequestEvent = _define(
    412,
    "REQUEST_EVENT",
    33,
    "<HHBB",
    ("first_sequence", "last_sequence", "target_system", "target_component"),
)
ResponseEventError = _define(
    413,
    "RESPONSE_EVENT_ERROR",
    77,
    "<HHBBB",
    ("sequence", "sequence_oldest_available", "target_system", "target_component", "reason"),
)
