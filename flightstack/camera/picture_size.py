"""Read how large a coded image will be from its own header, before anything is allocated."""

import struct

MAX_PIXELS = 1 << 24  # 4096 x 4096: 50 MB of bytes once decoded
PNG_START = b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR"
JPEG_START = b"\xff\xd8"
JPEG_SIZES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}  # SOF0 to SOF15: where sizes stand
JPEG_ALONE = frozenset((0x01, *range(0xD0, 0xD8)))  # markers that no length follows
JPEG_NO_HEADER = frozenset((0xD8, 0xD9, 0xDA))  # a picture, the end, the data: no size before them


def picture_size(content: bytes) -> tuple[int, int] | None:
    """Read height and width of a PNG or JPEG; None where the bytes are neither."""
    if content.startswith(PNG_START):
        return _png_size(content)
    return _jpeg_size(content) if content.startswith(JPEG_START) else None


def is_welcome(content: bytes) -> bool:
    """Whether these bytes are a PNG or JPEG of 1 to MAX_PIXELS pixels, by their own header."""
    size = picture_size(content)
    return size is not None and 0 < size[0] * size[1] <= MAX_PIXELS


def _png_size(content: bytes) -> tuple[int, int] | None:
    begin = len(PNG_START)
    if len(content) < begin + 8:
        return None
    width, height = struct.unpack_from(">II", content, begin)
    return height, width


def _jpeg_size(content: bytes) -> tuple[int, int] | None:
    """Go from segment to segment (ITU T.81, B.1.1) up to the first that tells the size."""
    at = len(JPEG_START)
    while at + 9 <= len(content) and content[at] == 0xFF:
        marker = content[at + 1]
        if marker in JPEG_SIZES:
            height, width = struct.unpack_from(">HH", content, at + 5)
            return height, width
        if marker in JPEG_NO_HEADER:
            return None
        if marker == 0xFF:  # fill
            at += 1
        elif marker in JPEG_ALONE:
            at += 2
        else:
            at += 2 + max(2, struct.unpack_from(">H", content, at + 2)[0])
    return None
