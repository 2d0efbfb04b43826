"""The CRC-32 of MAVLink: of parameters and of files."""

import zlib


def crc32(data: bytes, state: int = 0) -> int:
    """Extend a CRC-32 that is inverted neither at start nor end, as PX4 and QGroundControl do."""
    return zlib.crc32(data, state ^ 0xFFFFFFFF) ^ 0xFFFFFFFF
