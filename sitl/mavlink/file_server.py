"""Answer file transfer and log download: there are no files and no logs.

A clean refusal lets clients go on at once, for instance to the parameter protocol.
"""

import struct

from sitl.mavlink.dialect import Message, mavlink
from sitl.mavlink.request import Request

HEADER = struct.Struct("<HBBBBBBI")  # sequence, session, opcode, size, request, burst, 0, offset
PAYLOAD_BYTES = 251
TERMINATE_SESSION, RESET_SESSIONS = 1, 2
FILE_OPCODES = {3, 4, 14, 15}  # list, open for reading, CRC32, burst read
ACK, NAK = 128, 129
UNKNOWN_COMMAND, FILE_NOT_FOUND = 7, 10


def answer_file_transfer(message: Message, request: Request) -> None:
    """Answer FILE_TRANSFER_PROTOCOL."""
    sequence, session, opcode, *_ = HEADER.unpack(bytes(message.payload[: HEADER.size]))
    if opcode in (ACK, NAK):
        return
    error = b""
    if opcode not in (TERMINATE_SESSION, RESET_SESSIONS):
        error = bytes((FILE_NOT_FOUND if opcode in FILE_OPCODES else UNKNOWN_COMMAND,))
    header = HEADER.pack(
        (sequence + 1) & 0xFFFF, session, NAK if error else ACK, len(error), opcode, 0, 0, 0
    )
    request.outlet.send(
        mavlink.MAVLink_file_transfer_protocol_message(
            0, request.system, request.component, (header + error).ljust(PAYLOAD_BYTES, b"\0")
        )
    )


def answer_log_list(_message: Message, request: Request) -> None:
    """Answer LOG_REQUEST_LIST: none."""
    request.outlet.send(mavlink.MAVLink_log_entry_message(0, 0, 0, 0, 0))
