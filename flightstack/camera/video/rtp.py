"""Put the packets of an RTP stream of H.264 together into pictures (RFC 3550, RFC 6184).

FFmpeg would do so, too, but ends a picture where the next one begins, one period late: the marker
that ends it is lost between its layers. Pictures that lack a packet are left out, and those that
may build on them, up to the next whole one.
"""

import struct
from dataclasses import dataclass

VERSION = 2
HEADER = struct.Struct(">BBHII")  # version and counts, marker and kind, sequence, stamp, source
SOURCE_BYTES, EXTENSION_BYTES = 4, 4
TICK_S = 1 / 90_000  # of video, RFC 6184, 8.2.1
WRAP = 1 << 32
START = b"\0\0\0\1"  # before each unit, as decoders want it
SINGLE_LAST, AGGREGATE, FRAGMENT = 23, 24, 28  # kinds of payload
WHOLE_PICTURE = 5  # kind of a unit that builds on no other: IDR
MAX_PICTURE_BYTES = 8 << 20
MAX_WAIT_S = 2.0  # for a whole picture; some encoders never send one and refresh in stripes


@dataclass(frozen=True, slots=True)
class CodedPicture:
    """One picture as a decoder takes it, and its stamp in seconds of the stream's clock."""

    data: bytes
    stamp_s: float


class PictureAssembler:
    """Take packets in the order of arrival; give a picture when its last one is there."""

    def __init__(self) -> None:
        self._units = bytearray()  # of the picture that is being put together
        self._source: int | None = None  # whose stream it is
        self._sequence: int | None = None  # of the newest packet
        self._ticks: int | None = None  # the newest stamp, unwrapped
        self._is_whole = False  # the picture has a unit that builds on no other
        self._is_broken = False  # a packet of it is missing
        self._lost_s: float | None = None  # since when pictures have nothing whole to build on

    def take(self, packet: bytes) -> CodedPicture | None:
        """Take one packet; what is no RTP of this stream passes by."""
        payload = _payload(packet)
        if payload is None:
            return None
        _, marker, sequence, stamp, source = HEADER.unpack_from(packet)
        if source != self._source:  # another stream, or the first
            self._source, self._sequence, self._ticks = source, None, None
            self._is_whole, self._is_broken, self._lost_s = False, False, None
            self._units.clear()
        stamp_s = self._unwrap(stamp) * TICK_S
        if self._sequence is not None and sequence != (self._sequence + 1) % 65536:
            self._is_broken = True
        self._sequence = sequence
        self._add(payload)
        return self._finish(stamp_s) if marker & 0x80 else None

    def _finish(self, stamp_s: float) -> CodedPicture | None:
        data, whole, broken = bytes(self._units), self._is_whole, self._is_broken
        self._units.clear()
        self._is_whole = self._is_broken = False
        if broken:
            self._lost_s = stamp_s if self._lost_s is None else self._lost_s
            return None
        if whole or self._lost_s is None or stamp_s - self._lost_s > MAX_WAIT_S:
            self._lost_s = None
            return CodedPicture(data, stamp_s) if data else None
        return None

    def _add(self, payload: bytes) -> None:
        kind = payload[0] & 0x1F
        if len(self._units) + len(payload) > MAX_PICTURE_BYTES:
            self._is_broken = True
            self._units.clear()
        elif kind <= SINGLE_LAST:
            self._add_unit(payload)
        elif kind == AGGREGATE:
            rest = payload[1:]
            while len(rest) > 2:
                size = int.from_bytes(rest[:2], "big")
                self._add_unit(rest[2 : 2 + size])
                rest = rest[2 + size :]
        elif kind == FRAGMENT and len(payload) > 2:
            if payload[1] & 0x80:  # the first: the header of the unit is split over two bytes
                self._add_unit(bytes(((payload[0] & 0xE0) | (payload[1] & 0x1F),)))
            self._units += payload[2:]

    def _add_unit(self, unit: bytes) -> None:
        if unit:
            self._is_whole |= unit[0] & 0x1F == WHOLE_PICTURE
            self._units += START + unit

    def _unwrap(self, stamp: int) -> int:
        """Count on where 32 bits begin anew, and back where a stamp is older."""
        if self._ticks is None:
            self._ticks = stamp
        ahead = (stamp - self._ticks + WRAP // 2) % WRAP - WRAP // 2
        self._ticks += ahead
        return self._ticks


def is_rtp(packet: bytes) -> bool:
    """Whether this can be RTP, and not an MPEG transport stream."""
    return len(packet) > HEADER.size and packet[0] >> 6 == VERSION


def _payload(packet: bytes) -> bytes | None:
    """Return what a packet carries; None where it is no RTP, or carries nothing."""
    if not is_rtp(packet):
        return None
    begin = HEADER.size + SOURCE_BYTES * (packet[0] & 0x0F)
    if packet[0] & 0x10:
        if len(packet) < begin + EXTENSION_BYTES:
            return None
        begin += EXTENSION_BYTES + 4 * int.from_bytes(packet[begin + 2 : begin + 4], "big")
    end = len(packet) - (packet[-1] if packet[0] & 0x20 else 0)
    return packet[begin:end] or None if begin < end else None
