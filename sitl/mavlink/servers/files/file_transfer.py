"""The payload of FILE_TRANSFER_PROTOCOL: requests in, acknowledgements and refusals out."""

import struct
from enum import IntEnum
from typing import NamedTuple

HEADER = struct.Struct("<HBBBBBBI")  # sequence, session, opcode, size, request, burst, 0, offset
PAYLOAD_BYTES = 251
DATA_BYTES = PAYLOAD_BYTES - HEADER.size
ACK, NAK = 128, 129


class Opcode(IntEnum):
    """What may be requested."""

    NONE = 0
    TERMINATE_SESSION = 1
    RESET_SESSIONS = 2
    LIST_DIRECTORY = 3
    OPEN_FILE = 4
    READ_FILE = 5
    CRC32 = 14
    BURST_READ = 15


class Problem(IntEnum):
    """MAV_FTP_ERR."""

    FAIL = 1
    INVALID_SIZE = 3
    INVALID_SESSION = 4
    NO_SESSIONS = 5
    END_OF_FILE = 6
    UNKNOWN_COMMAND = 7
    PROTECTED = 9
    NOT_FOUND = 10


class FileQuery(NamedTuple):
    """One request, as it was sent."""

    sequence: int
    session: int
    opcode: int
    size: int
    offset: int
    data: bytes

    @property
    def path(self) -> str:
        """The data as a path."""
        text, _, _ = self.data.partition(b"\0")
        return text.decode(errors="surrogateescape")


class FileReply(NamedTuple):
    """One reply."""

    session: int
    data: bytes
    offset: int = 0
    is_last: bool = True  # of a burst


def read_query(payload: bytes) -> FileQuery:
    """Read a request."""
    sequence, session, opcode, size, _, _, _, offset = HEADER.unpack(payload[: HEADER.size])
    data = payload[HEADER.size : HEADER.size + size]
    return FileQuery(sequence, session, opcode, size, offset, data)


def accept(query: FileQuery, answer: FileReply, number: int) -> bytes:
    """Make the payload of an ACK, the one of that number in a burst."""
    sequence = (query.sequence + 1 + number) & 0xFFFF
    is_burst_end = query.opcode == Opcode.BURST_READ and answer.is_last
    size = len(answer.data)
    return HEADER.pack(
        sequence, answer.session, ACK, size, query.opcode, is_burst_end, 0, answer.offset
    ) + answer.data.ljust(DATA_BYTES, b"\0")


def refuse(query: FileQuery, problem: Problem) -> bytes:
    """Make the payload of a NAK."""
    sequence = (query.sequence + 1) & 0xFFFF
    header = HEADER.pack(sequence, query.session, NAK, 1, query.opcode, 0, 0, query.offset)
    return header + bytes((problem,)).ljust(DATA_BYTES, b"\0")
