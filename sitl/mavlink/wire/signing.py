"""MAVLink 2 signatures: sign what goes out, judge what comes in.

A signature is the link's id, a stamp (48 bits, units of 10 us since 2015) and the first 6 bytes
of SHA-256 over key, packet, link id and stamp. A packet is judged in this order: first the
signature itself, in constant time; then its stamp. Nothing is remembered of a packet that fails,
so a forged one cannot push a stream's stamp ahead. The table of streams is bounded: a stream that
has been silent for longer than `TOLERANCE` may be forgotten, since its old packets are then too
old to be taken for a new stream's. What was signed before the start is too old as well: nothing is
known of the streams of an earlier process, whose packets may come again.
"""

import hashlib
import hmac
import struct
import time
from collections.abc import Callable

from sitl.mavlink.wire.dialect import mavlink
from sitl.mavlink.wire.packets import SIGNATURE_BYTES, Received
from sitl.mavlink.wire.refusals import Refusal

KEY_BYTES = 32
NO_KEY = bytes(KEY_BYTES)  # in SETUP_SIGNING: sign no more
MAC_BYTES = 6
EPOCH_S = 1_420_070_400  # 2015-01-01, where stamps count from
UNITS_PER_S = 100_000
TOLERANCE = 60 * UNITS_PER_S  # how far a clock may be off; MAVLink's one minute
MAX_STREAMS = 64
MAX_STAMP = 2**48 - 1
MAY_BE_UNSIGNED = {  # as PX4
    mavlink.MAVLINK_MSG_ID_HEARTBEAT,
    mavlink.MAVLINK_MSG_ID_RADIO_STATUS,
    mavlink.MAVLINK_MSG_ID_ADSB_VEHICLE,
    mavlink.MAVLINK_MSG_ID_COLLISION,
}

Stream = tuple[int, int, int]  # link id, system, component

_LINK_AND_STAMP = struct.Struct("<BIH")


def wall_stamp(time_ns: int) -> int:
    """Give the stamp of a wall clock's ns since 1970."""
    return max(0, time_ns // 10_000 - EPOCH_S * UNITS_PER_S)


def make_clock() -> Callable[[], int]:
    """Make a clock of stamps that never goes back: the wall clock now, then the steady one."""
    offset_ns = time.time_ns() - time.monotonic_ns()
    return lambda: wall_stamp(time.monotonic_ns() + offset_ns)


class Signing:
    """The key of one vehicle on all its links, and what was accepted under it."""

    def __init__(
        self,
        key: bytes | None = None,
        *,
        clock: Callable[[], int] | None = None,
        keep: Callable[[bytes | None], None] = lambda _key: None,
    ) -> None:
        """Start with a key or without; `clock` gives stamps, `keep` stores a new key."""
        self._key = key
        self._clock = clock or make_clock()
        self._start = self._clock()
        self._keep = keep
        self._ahead = 0  # of the clock, as SETUP_SIGNING may ask for
        self._last_sent = 0
        self._streams: dict[Stream, int] = {}  # the last accepted stamp

    @property
    def is_on(self) -> bool:
        """Whether there is a key."""
        return self._key is not None

    def set_up(self, key: bytes, initial_stamp: int) -> None:
        """Take over the key of a SETUP_SIGNING; the stamps seen so far still count."""
        self._key = None if key == NO_KEY else key
        self._ahead = max(self._ahead, min(initial_stamp, MAX_STAMP // 2) - self._clock())
        self._keep(self._key)

    def signature(self, signed_packet: bytes, link: int) -> bytes:
        """Sign a packet that ends with its checksum and has the signed flag."""
        if self._key is None:
            raise ValueError("there is no key to sign with")
        self._last_sent = max(self._now(), self._last_sent + 1)
        stamp = self._last_sent
        tail = _LINK_AND_STAMP.pack(link, stamp & 0xFFFFFFFF, stamp >> 32)
        return tail + _mac(self._key, signed_packet + tail)

    def judge(self, received: Received) -> Refusal | None:
        """Accept a packet (None) and remember its stamp, or say why not and remember nothing."""
        if self._key is None:
            return None
        if not received.is_signed:
            unsigned_is_fine = received.message_id in MAY_BE_UNSIGNED
            return None if unsigned_is_fine else Refusal.UNSIGNED
        raw = received.raw
        if not hmac.compare_digest(_mac(self._key, raw[:-MAC_BYTES]), raw[-MAC_BYTES:]):
            return Refusal.BAD_SIGNATURE
        link, low, high = _LINK_AND_STAMP.unpack(raw[-SIGNATURE_BYTES:-MAC_BYTES])
        return self._take((link, received.system, received.component), low | high << 32)

    def _take(self, stream: Stream, stamp: int) -> Refusal | None:
        """Judge the stamp of an authentic packet."""
        now, last = self._now(), self._streams.get(stream)
        if stamp > now + TOLERANCE:
            return Refusal.FUTURE
        if last is not None and stamp <= last:
            return Refusal.REPLAYED
        if last is None:
            if stamp < max(now - TOLERANCE, self._start):
                return Refusal.STALE
            if not self._has_room(now):
                return Refusal.CROWDED
        self._streams[stream] = stamp
        return None

    def _has_room(self, now: int) -> bool:
        if len(self._streams) >= MAX_STREAMS:
            oldest = now - TOLERANCE
            self._streams = {s: stamp for s, stamp in self._streams.items() if stamp >= oldest}
        return len(self._streams) < MAX_STREAMS

    def _now(self) -> int:
        return self._clock() + self._ahead


def _mac(key: bytes, data: bytes) -> bytes:
    return hashlib.sha256(key + data).digest()[:MAC_BYTES]
