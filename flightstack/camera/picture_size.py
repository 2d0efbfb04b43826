"""Judge a coded image by its own structure, before a decoder allocates anything for it.

A header of a few bytes can ask for any number of pixels, and the length of a PNG chunk for 4 GB.
"""

import struct

MAX_PIXELS = 1 << 24  # 4096 x 4096: 50 MB of bytes once decoded
MAX_PIECES = 1 << 14  # chunks of a PNG, segments of a JPEG before its size
MAX_SCANS = 64  # of a progressive JPEG: each goes over all pixels
PNG_START = b"\x89PNG\r\n\x1a\n"
PNG_HEADER = struct.Struct(">I4sII")  # length, kind, width, height
PNG_CHUNK = struct.Struct(">I4s")
PNG_OVERHEAD = 12  # length, kind and checksum
PNG_MOVING = frozenset((b"acTL", b"fcTL", b"fdAT"))  # an animation has pictures of other sizes
JPEG_START = b"\xff\xd8"
JPEG_SIZES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}  # SOF0 to SOF15: where sizes stand
JPEG_ALONE = frozenset((0x01, *range(0xD0, 0xD8)))  # markers that no length follows
JPEG_NO_HEADER = frozenset((0xD8, 0xD9, 0xDA))  # a picture, the end, the data: no size before them
JPEG_SCAN = b"\xff\xda"


def picture_size(content: bytes) -> tuple[int, int] | None:
    """Read height and width of a PNG or JPEG; None where the bytes are no such picture."""
    if content.startswith(PNG_START):
        return _png_size(content)
    return _jpeg_size(content) if content.startswith(JPEG_START) else None


def is_welcome(content: bytes) -> bool:
    """Whether these bytes are a PNG or JPEG of 1 to MAX_PIXELS pixels that may be decoded."""
    size = picture_size(content)
    return size is not None and 0 < size[0] * size[1] <= MAX_PIXELS


def _png_size(content: bytes) -> tuple[int, int] | None:
    """Go from chunk to chunk (PNG specification, 5.3): all there, one header, no animation."""
    at = len(PNG_START)
    if len(content) < at + PNG_HEADER.size:
        return None
    _, first, width, height = PNG_HEADER.unpack_from(content, at)
    if first != b"IHDR":
        return None
    for number in range(MAX_PIECES):
        if at + PNG_OVERHEAD > len(content):
            return None
        length, kind = PNG_CHUNK.unpack_from(content, at)
        at += PNG_OVERHEAD + length
        if at > len(content) or kind in PNG_MOVING or (kind == b"IHDR" and number):
            return None
        if kind == b"IEND":  # nothing behind it that could be taken for a chunk
            is_last = length == 0 and len(content) - at < PNG_CHUNK.size
            return (height, width) if is_last else None
    return None


def _jpeg_size(content: bytes) -> tuple[int, int] | None:
    """Go from segment to segment (ITU T.81, B.1.1) up to the first that tells the size."""
    at = len(JPEG_START)
    for _ in range(MAX_PIECES):
        if at + 9 > len(content) or content[at] != 0xFF:
            return None
        marker = content[at + 1]
        if marker in JPEG_SIZES:
            height, width = struct.unpack_from(">HH", content, at + 5)
            return (height, width) if content.count(JPEG_SCAN, at) <= MAX_SCANS else None
        if marker in JPEG_NO_HEADER:
            return None
        if marker == 0xFF:  # fill
            at += 1
        elif marker in JPEG_ALONE:
            at += 2
        else:
            at += 2 + max(2, struct.unpack_from(">H", content, at + 2)[0])
    return None
