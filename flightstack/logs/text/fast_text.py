"""Write columns as text without a Python step a value.

Numbers of one kind are written row by row into one string, and cut at its commas into cells; texts
are cells already. Cells of all columns are copied, each as wide as the widest, to where they belong
in the lines: in their order, so that what one has too much gives way to the next, and then the
constant text between them. Numbers look as `str` writes them; orjson writes them fifteen times
faster, where it is installed and where it agrees.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.tlog.byte_view import at_every_byte

Bytes = NDArray[np.uint8]
Places = NDArray[np.int64]
Part = str | NDArray[np.generic]  # of a line: a constant, (n,) numbers, or (n, width) Bytes
ONE_DIGIT = (1e-10, 1e-5)  # between these orjson writes e-7 where `str` writes e-07
NO_EXPONENT = (1e-5, 1e-4)  # between these orjson writes no exponent, but `str` does
MAX_NUMBER_LENGTH = 24  # -2.2250738585072014e-308
Rewritten = tuple[NDArray[np.intp], Bytes]  # rows, and their new texts


class Cells(NamedTuple):
    """Where pieces of text lie in a pool."""

    start: Places
    length: Places


class Pool:
    """Bytes of many cells."""

    def __init__(self) -> None:
        self._parts: list[Bytes] = []
        self._size = 0

    def add(self, text: Bytes) -> int:
        """Add bytes and return where they begin."""
        self._parts.append(text)
        self._size += len(text)
        return self._size - len(text)

    def joined(self, room: int) -> Bytes:
        """Return all bytes, and this many NULs."""
        return np.concatenate([*self._parts, np.zeros(room, dtype=np.uint8)])


class Lines(NamedTuple):
    """Lines one after the other."""

    text: Bytes
    ends: Places  # one a line


def _listed_by_repr(values: NDArray[np.generic]) -> bytes:
    return b"[%b]" % ",".join(map(repr, values.tolist())).encode()


def _find_lister() -> Callable[[NDArray[np.generic]], bytes]:
    try:
        import orjson  # noqa: PLC0415
    except ImportError:
        return _listed_by_repr
    return partial(orjson.dumps, option=orjson.OPT_SERIALIZE_NUMPY)


_listed = _find_lister()  # [1.5,-2.0]


def from_texts(values: Sequence[str]) -> Bytes:
    """Return strings as a matrix, UTF-8, padded with NUL; NULs in them are lost."""
    array = np.array([value.encode(errors="replace") for value in values], dtype=np.bytes_)
    width = max(array.itemsize, 1)
    return array.view(np.uint8).reshape(-1, width) if len(array) else np.empty((0, 1), np.uint8)


def _from_matrix(matrix: Bytes, pool: Pool) -> Cells:
    """Return the rows of a matrix, without the NULs in them."""
    is_text = matrix != 0
    length = np.count_nonzero(is_text, axis=1)
    start = np.cumsum(length) - length
    start += pool.add(matrix[is_text])
    return Cells(start, length)


def _cut(listed: Bytes) -> Cells:
    """Return the values of a list, without its last byte."""
    edges = np.concatenate(([0], np.flatnonzero(listed == ord(",")), [len(listed)]))
    return Cells(edges[:-1] + 1, np.diff(edges) - 1)


def _matrix(listed: Bytes, cells: Cells, rows: NDArray[np.intp]) -> Bytes:
    """Return the numbers in these rows as a matrix, padded with NUL."""
    length = cells.length[rows, None]
    count = np.arange(MAX_NUMBER_LENGTH)
    matrix = listed[np.minimum(cells.start[rows, None] + count, len(listed) - 1)]
    return np.where(count < length, matrix, np.uint8(0))


def _rewritten(values: NDArray[np.float64], listed: Bytes, cells: Cells) -> Iterator[Rewritten]:
    """Yield numbers that `str` writes otherwise than orjson."""
    size = np.abs(values)
    small = np.flatnonzero(size < NO_EXPONENT[1])
    size = size[small]
    for (low, high), rewritten in REWRITTEN:
        rows = small[(size >= low) & (size < high)]
        if len(rows):
            yield rows, rewritten(_matrix(listed, cells, rows))


def _not_finite(values: NDArray[np.float64]) -> Bytes:
    """Return NaN and infinities as `str` writes them."""
    words = from_texts(["nan", "inf", "-inf"])
    return words[np.where(np.isnan(values), 0, np.where(values > 0, 1, 2))]


def _with_exponent(numbers: Bytes) -> Bytes:
    """Return 0.0000123 as 1.23e-05; rows that `repr` made already so stay as they are."""
    negative = numbers[:, 0] == ord("-")
    plain = np.where(negative[:, None], np.roll(numbers, -1, axis=1), numbers)
    if (plain[:, 1] != ord(".")).any() or (plain[:, 2] != ord("0")).any():
        return numbers
    sign = np.where(negative, ord("-"), 0).astype(np.uint8)[:, None]
    digits = plain[:, len("0.0000") :].copy()
    digits[negative, -1] = 0  # where the sign was rolled to
    point = np.where(digits[:, 1] != 0, ord("."), 0).astype(np.uint8)[:, None]
    exponent = np.broadcast_to(np.frombuffer(b"e-05", dtype=np.uint8), (len(numbers), 4))
    return np.hstack((sign, digits[:, :1], point, digits[:, 1:], exponent))


def _with_two_digits(numbers: Bytes) -> Bytes:
    """Return 1.23e-7 as 1.23e-07; rows that `repr` made already so stay as they are."""
    count = np.arange(len(numbers))
    last = np.count_nonzero(numbers, axis=1) - 1
    short = np.flatnonzero(numbers[count, last - 1] == ord("-"))
    numbers[short, last[short] + 1] = numbers[short, last[short]]
    numbers[short, last[short]] = ord("0")
    return numbers


REWRITTEN = ((ONE_DIGIT, _with_two_digits), (NO_EXPONENT, _with_exponent))


def _numbers(columns: Sequence[NDArray[np.generic]], kind: str, pool: Pool) -> Cells:
    """Return columns of numbers row by row."""
    values = np.empty((len(columns[0]), len(columns)), dtype=kind)
    with np.errstate(invalid="ignore"):  # signalling NaNs of damaged floats
        for index, column in enumerate(columns):
            values[:, index] = column
    flat = values.reshape(-1)
    special = np.flatnonzero(~np.isfinite(flat))
    text = _listed(np.where(np.isfinite(flat), flat, 0) if len(special) else flat)
    listed = np.frombuffer(text, dtype=np.uint8, count=len(text) - 1)
    cells = _cut(listed)
    start = cells.start + pool.add(listed)
    if kind == "f8":
        floats = flat.view(np.float64)
        for rows, texts in _rewritten(floats, listed, cells):
            start[rows], cells.length[rows] = _from_matrix(texts, pool)
        if len(special):
            words = _not_finite(floats[special])
            start[special], cells.length[special] = _from_matrix(words, pool)
    return Cells(start, cells.length)


def _kind(column: NDArray[np.generic]) -> str:
    """Return the type that a column is written as: for numbers one that holds its every value."""
    if column.ndim == 2:
        return "text"
    if column.dtype.kind == "f":
        return "f8"
    return "u8" if column.dtype == np.uint64 else "i8"


def _by_kind(
    columns: Sequence[NDArray[np.generic]], pool: Pool
) -> Iterator[tuple[list[int], Cells]]:
    """Yield which columns are of a kind, and the cells of these, row by row."""
    kinds = [_kind(column) for column in columns]
    for kind in sorted(set(kinds) - {"text"}):
        members = [index for index, each in enumerate(kinds) if each == kind]
        yield members, _numbers([columns[index] for index in members], kind, pool)
    for index, kind in enumerate(kinds):
        if kind == "text":
            yield [index], _from_matrix(columns[index].view(np.uint8), pool)


def _cells(columns: Sequence[NDArray[np.generic]], count: int, pool: Pool) -> Cells:
    """Return the cells of columns, (n, columns) of them."""
    start = np.empty((count, len(columns)), dtype=np.int64)
    length = np.empty_like(start)
    for members, cells in _by_kind(columns, pool):
        for place, index in enumerate(members):
            start[:, index] = cells.start[place :: len(members)]
            length[:, index] = cells.length[place :: len(members)]
    return Cells(start, length)


def beside(parts: Sequence[Part], count: int) -> Lines:
    """Return constants, numbers and text side by side, for this many rows."""
    if not count:
        return Lines(np.empty(0, dtype=np.uint8), np.empty(0, dtype=np.int64))
    fixed: list[tuple[int, int, Bytes]] = []  # cells and fixed bytes before it, what it is
    columns: list[NDArray[np.generic]] = []
    shifts: list[int] = []  # fixed bytes before each column
    width = 0
    for part in parts:
        block = _constant(part)
        if block is None:
            columns.append(np.asarray(part))
            shifts.append(width)
        elif block.size:
            fixed.append((len(columns), width, block))
            width += block.shape[1]
    pool = Pool()
    cells = _cells(columns, count, pool)
    room = int(cells.length.max(initial=1))
    places = _places(cells.length, width)
    size = int(places[-1, -1]) + width
    text = np.empty(size + room, dtype=np.uint8)
    to = places[:, :-1] + np.array(shifts, dtype=np.int64)
    piece = f"V{room}"
    at_every_byte(text, piece)[to] = at_every_byte(pool.joined(room), piece)[cells.start]
    for place, shift, block in fixed:
        piece = f"V{block.shape[1]}"
        at_every_byte(text, piece)[places[:, place] + shift] = block.reshape(-1).view(piece)
    return Lines(text[:size], places[:, -1] + width)


def _places(length: Places, width: int) -> Places:
    """Return where cells begin in lines with `width` bytes more, were these at each line's end.

    One more column tells where the last cell of each line ends.
    """
    count, columns = length.shape
    places = np.zeros((count, columns + 1), dtype=np.int64)
    np.cumsum(length, axis=1, out=places[:, 1:])
    whole = places[:, -1] + width
    places += (np.cumsum(whole) - whole)[:, None]
    return places


def _constant(part: Part) -> Bytes | None:
    """Return text that is equally long in all lines, as one row or as many; None for others."""
    if isinstance(part, str):
        return np.frombuffer(part.encode(), dtype=np.uint8)[None]
    if part.ndim == 2 and part.all():
        return np.ascontiguousarray(part).view(np.uint8)
    return None


def as_list(column: NDArray[np.generic]) -> list[Part]:
    """Return the parts that write rows of an array as Python lists."""
    parts: list[Part] = ["["]
    for index in range(column.shape[1]):
        parts += [", " if index else "", column[:, index]]
    return [*parts, "]"]


def text_of(lines: Lines) -> bytes:
    """Return the text of all lines."""
    return lines.text.tobytes()


def lines_of(lines: Lines) -> list[bytes]:
    """Return the text of each line."""
    text, stops = text_of(lines), lines.ends.tolist()
    return [text[start:stop] for start, stop in zip([0, *stops], stops, strict=False)]
