"""Sign MAVLink 2 packets, and tell genuine ones from forged, replayed and unsigned ones.

A signed packet ends in 13 bytes: link id (1), timestamp (6, in 10 us since 2015), and the first 6
bytes of SHA-256 over key, packet, link id and timestamp. The hash is looked at first, so that
nothing that was written without the key can change what is known here.

A stream is a (link id, system, component); its timestamps must grow. The first of a stream may be
a minute behind our own: within that minute what was sent before our start can be replayed to us.
Our own timestamp is that of the wall clock at our start and the time since, and more than all that
we have sent or believed: a wall clock that is set in flight does no harm, and a companion without
one goes by the vehicle's.

Reference: MAVLink developer guide, "Message Signing".
"""

import hashlib
import hmac
import time
from collections.abc import Callable
from enum import Enum
from pathlib import Path

from pymavlink.dialects.v20 import common

from flightstack.errors import UsageError
from flightstack.mavlink.packets import checksum, is_signed, message_id, source_of
from flightstack.mavlink_numbers import CHECKSUM_BYTES, HEADER_V2, SIGNATURE_BYTES, SIGNED_FLAG

KEY_BYTES = 32
MAC_BYTES = 6
STAMP_BYTES = 6
EPOCH_S = 1_420_070_400  # 2015-01-01 00:00 UTC, in Unix time
TICKS_PER_S = 100_000
LATEST_TICKS = (1 << 8 * STAMP_BYTES) - 1  # the year 2104
MINUTE_TICKS = 60 * TICKS_PER_S  # how far a new stream may be behind
MAX_STREAMS = 16  # as many as MAVLink's C library keeps
OPEN_MESSAGES = frozenset(  # that PX4 takes unsigned, too
    {
        common.MAVLINK_MSG_ID_HEARTBEAT,
        common.MAVLINK_MSG_ID_RADIO_STATUS,
        common.MAVLINK_MSG_ID_ADSB_VEHICLE,
        common.MAVLINK_MSG_ID_COLLISION,
    }
)


class Verdict(Enum):
    """What a packet is, and for those that are refused why."""

    GENUINE = "genuine"
    OPEN = "not signed, and need not be"
    UNSIGNED = "not signed"
    FORGED = "not signed with our key"
    REPLAYED = "not newer than what came before"
    STALE = "stamped more than a minute ago: are both clocks right?"
    CROWDED = "from too many senders"


class Signing:
    """One key and what has been sent and believed under it; for one thread."""

    def __init__(
        self, key: bytes, *, link_id: int = 0, wall_s: Callable[[], float] | None = None
    ) -> None:
        if len(key) != KEY_BYTES:
            raise ValueError(f"key: expected {KEY_BYTES} bytes, got {len(key)}")
        self._keyed = hashlib.sha256(key)
        self._link_id = link_id
        self._wall_s = wall_s or steady_wall_clock()  # Unix time
        self._newest = 0  # timestamp that was sent or believed
        self._streams: dict[tuple[int, int, int], int] = {}  # newest timestamp of each

    def sign(self, packet: bytes) -> bytes:
        """Return an unsigned MAVLink 2 packet as a signed one."""
        body = bytearray(packet[: HEADER_V2 + packet[1]])
        body[2] |= SIGNED_FLAG
        body += checksum(bytes(body)).to_bytes(CHECKSUM_BYTES, "little")
        self._newest = min(max(self._newest + 1, self._wall_ticks()), LATEST_TICKS)
        body.append(self._link_id)
        body += self._newest.to_bytes(STAMP_BYTES, "little")
        return bytes(body) + self._mac(bytes(body))

    def verify(self, packet: bytes) -> Verdict:
        """Judge a whole packet; only a genuine one leaves a trace."""
        if not is_signed(packet):
            return Verdict.OPEN if message_id(packet) in OPEN_MESSAGES else Verdict.UNSIGNED
        if not hmac.compare_digest(self._mac(packet[:-MAC_BYTES]), packet[-MAC_BYTES:]):
            return Verdict.FORGED
        signature = packet[-SIGNATURE_BYTES:]
        stamp = int.from_bytes(signature[1 : 1 + STAMP_BYTES], "little")
        stream = (signature[0], *source_of(packet))
        refusal = self._find_fault(stream, stamp)
        if refusal is not None:
            return refusal
        self._streams[stream] = stamp
        self._newest = max(self._newest, stamp)
        return Verdict.GENUINE

    def _find_fault(self, stream: tuple[int, int, int], stamp: int) -> Verdict | None:
        newest = self._streams.get(stream)
        if newest is not None:
            return Verdict.REPLAYED if stamp <= newest else None
        if stamp + MINUTE_TICKS < max(self._newest, self._wall_ticks()):
            return Verdict.STALE
        return Verdict.CROWDED if len(self._streams) >= MAX_STREAMS else None

    def _mac(self, signed: bytes) -> bytes:
        keyed = self._keyed.copy()
        keyed.update(signed)
        return keyed.digest()[:MAC_BYTES]

    def _wall_ticks(self) -> int:
        return max(0, int((self._wall_s() - EPOCH_S) * TICKS_PER_S))


def steady_wall_clock() -> Callable[[], float]:
    """Make a clock of Unix time that goes on from now, whatever happens to the wall clock."""
    offset_s = time.time() - time.monotonic()
    return lambda: time.monotonic() + offset_s


def load_key(path: Path) -> bytes:
    """Read a key file: 32 bytes, or 64 hexadecimal digits; raises UsageError."""
    try:
        with path.open("rb") as file:
            content = file.read(4 * KEY_BYTES)
    except OSError as error:
        raise UsageError(f"signing key {path}: {error.strerror}") from error
    key = content
    if len(content) != KEY_BYTES:
        try:
            key = bytes.fromhex(content.decode("ascii"))
        except ValueError:
            key = b""
    if len(key) != KEY_BYTES:
        raise UsageError(
            f"signing key {path} holds neither {KEY_BYTES} bytes nor {2 * KEY_BYTES} hexadecimal "
            f"digits; make one by: openssl rand -hex {KEY_BYTES}"
        )
    if not any(key):
        raise UsageError(f"signing key {path} is all zeros, which to MAVLink means no key")
    return key
