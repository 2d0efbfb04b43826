"""Cut bytes into MAVLink frames, without decoding them.

A frame whose message is known must have a right checksum; one that is unknown to the dialect is
taken by its header if another frame, or nothing, follows it. On any doubt the search goes on at
the next byte, so that noise costs no more than the frames it hit.
"""

from pymavlink.dialects.v20 import common
from pymavlink.generator.mavcrc import mcrf4xx

MAGIC_V1, MAGIC_V2 = 0xFE, 0xFD
HEADER_V1, HEADER_V2 = 6, 10  # bytes
CHECKSUM_BYTES = 2
OVERHEAD_V1 = HEADER_V1 + CHECKSUM_BYTES
OVERHEAD_V2 = HEADER_V2 + CHECKSUM_BYTES
SIGNED_FLAG = 0x01  # incompatibility flag
SIGNATURE_BYTES = 13
CRC_START = 0xFFFF
CRC_EXTRA = {number: bytes([kind.crc_extra]) for number, kind in common.mavlink_map.items()}


def split_frames(data: bytes) -> tuple[list[bytes], int]:
    """Return the whole frames in `data`, and how many of its bytes are done with."""
    frames = []
    at, end = 0, len(data)
    while at < end:
        if data[at] != MAGIC_V2 and data[at] != MAGIC_V1:
            at += 1
            continue
        length = _frame_length(data, at, end)
        if at + length > end:
            break  # not all here yet
        frame = data[at : at + length]
        if _is_sound(frame, data, at + length):
            frames.append(frame)
            at += length
        else:
            at += 1
    return frames, at


class FrameSplitter:
    """Cut a byte stream whose reads end anywhere, as TCP and serial lines deliver it."""

    def __init__(self) -> None:
        self._rest = b""

    def split(self, data: bytes) -> list[bytes]:
        """Return the frames that `data` completes; keep what is unfinished."""
        data = self._rest + data
        frames, used = split_frames(data)
        self._rest = data[used:]
        return frames


def message_id(frame: bytes) -> int:
    """Read the message id of a whole frame."""
    if frame[0] == MAGIC_V2:
        return frame[7] | frame[8] << 8 | frame[9] << 16
    return frame[5]


def source_of(frame: bytes) -> tuple[int, int]:
    """Read the system and component that sent a whole frame."""
    return (frame[5], frame[6]) if frame[0] == MAGIC_V2 else (frame[3], frame[4])


def identify(frame: bytes) -> tuple[int, int, int]:
    """Read message id, system and component of a whole frame, in one go."""
    if frame[0] == MAGIC_V2:
        return frame[7] | frame[8] << 8 | frame[9] << 16, frame[5], frame[6]
    return frame[5], frame[3], frame[4]


def is_signed(frame: bytes) -> bool:
    """Whether a whole frame ends in a signature, whoever made it."""
    return frame[0] == MAGIC_V2 and bool(frame[2] & SIGNED_FLAG)


def checksum(frame: bytes) -> int:
    """Compute the checksum of a frame whose message the dialect knows; more may follow it."""
    end = frame[1] + (HEADER_V2 if frame[0] == MAGIC_V2 else HEADER_V1)
    value: int = mcrf4xx(frame[1:end] + CRC_EXTRA[message_id(frame)], CRC_START)
    return value


def _frame_length(data: bytes, at: int, end: int) -> int:
    """Read how long the frame at `at` is, or at least how much of it is needed to know."""
    if at + OVERHEAD_V1 > end:
        return OVERHEAD_V1
    if data[at] == MAGIC_V1:
        return data[at + 1] + OVERHEAD_V1
    if data[at + 2] & SIGNED_FLAG:
        return data[at + 1] + OVERHEAD_V2 + SIGNATURE_BYTES
    return data[at + 1] + OVERHEAD_V2


def _is_sound(frame: bytes, data: bytes, following: int) -> bool:
    extra = CRC_EXTRA.get(message_id(frame))
    if extra is None:
        return following == len(data) or data[following] in (MAGIC_V1, MAGIC_V2)
    end = frame[1] + (HEADER_V2 if frame[0] == MAGIC_V2 else HEADER_V1)
    found: int = mcrf4xx(frame[1:end] + extra, CRC_START)
    return found == frame[end] | frame[end + 1] << 8
