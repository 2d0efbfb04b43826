"""Write columns as text without a Python step a value.

Text is a matrix of bytes, one row a line, in which NULs stand for nothing: `text_of` drops them
all at once. Numbers are written row by row into one string, then cut at its commas into cells of
one width, which are laid into lines of constant text. Numbers look as `str` writes them; orjson
writes them fifteen times faster, where it is installed and where it agrees.
"""

from collections.abc import Callable, Sequence
from functools import partial
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]  # (n, width) text, padded with NUL
Part = str | NDArray[np.generic]  # what a line is made of: a constant, (n,) numbers, or Bytes
ONE_DIGIT = (1e-10, 1e-5)  # between these orjson writes e-7 where `str` writes e-07
NO_EXPONENT = (1e-5, 1e-4)  # between these orjson writes no exponent, but `str` does
LONGEST_NUMBER = 24  # -2.2250738585072014e-308
WORD = 8  # widths are multiples of it, so that whole words are copied


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
    """Return strings as a matrix, UTF-8; NULs in them are lost."""
    array = np.array([value.encode(errors="replace") for value in values], dtype=np.bytes_)
    width = max(array.itemsize, 1)
    return array.view(np.uint8).reshape(-1, width) if len(array) else np.empty((0, 1), np.uint8)


def _masks() -> NDArray[np.uint64]:
    """Return the masks that leave n bytes of a cell, for every n that there may be."""
    is_text = np.arange(LONGEST_NUMBER) < np.arange(LONGEST_NUMBER + 1)[:, None]
    return (is_text * np.uint8(0xFF)).view(np.uint64)


def _cells(listed: bytes) -> Bytes:
    """Return the values of a list, one a row."""
    flat = np.frombuffer(listed + bytes(LONGEST_NUMBER), dtype=np.uint8)
    ends = np.append(np.flatnonzero(flat == ord(",")), len(listed) - len("]"))
    starts = np.append(len("["), ends[:-1] + len(","))
    every_row = np.ndarray((len(listed) + 1,), f"V{LONGEST_NUMBER}", buffer=flat, strides=(1,))
    cells: Bytes = every_row[starts].view(np.uint8).reshape(len(starts), LONGEST_NUMBER)
    words = cells.view(np.uint64)
    words &= _masks().take(ends - starts, axis=0)
    return cells


def _rewrite(cells: Bytes, values: NDArray[np.float64]) -> None:
    """Write numbers anew where `str` and orjson differ; NaN and the infinities are zeros so far."""
    size = np.abs(values)
    special = np.flatnonzero(~(size < np.inf))
    if len(special):
        words = from_texts(["nan", "inf", "-inf"])
        which = np.where(np.isnan(values[special]), 0, np.where(values[special] > 0, 1, 2))
        cells[special] = 0
        cells[special, : words.shape[1]] = words[which]
    small = np.flatnonzero(size < NO_EXPONENT[1])
    for (least, most), rewritten in REWRITTEN:
        rows = small[(size[small] >= least) & (size[small] < most)]
        if len(rows):
            cells[rows] = rewritten(cells[rows])


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


def _numbers(prefixes: Sequence[str], columns: Sequence[NDArray[np.generic]], kind: str) -> Bytes:
    """Return columns of numbers side by side, each after its prefix."""
    values = np.empty((len(columns[0]), len(columns)), dtype=kind)
    with np.errstate(invalid="ignore"):  # signalling NaNs of damaged floats
        for index, column in enumerate(columns):
            values[:, index] = column
    flat = values.reshape(-1)
    finite = np.isfinite(flat)
    cells = _cells(_listed(flat if finite.all() else np.where(finite, flat, 0)))
    if kind == "f8":
        _rewrite(cells, flat.view(np.float64))
    return _laid_out(prefixes, cells)


def _laid_out(prefixes: Sequence[str], cells: Bytes) -> Bytes:
    """Return lines of cells, as many in each as there are prefixes, one before each cell."""
    constants = from_texts(prefixes)
    room = -(-constants.shape[1] // WORD) * WORD
    line = np.zeros((len(prefixes), room + LONGEST_NUMBER), dtype=np.uint8)
    line[:, : constants.shape[1]] = constants
    lines = np.tile(line.reshape(-1), (len(cells) // len(prefixes), 1))
    to, words = lines.view(np.uint64).reshape(len(cells), -1), cells.view(np.uint64)
    for index in range(LONGEST_NUMBER // WORD):
        to[:, room // WORD + index] = words[:, index]
    return lines


def _kind(column: NDArray[np.generic]) -> str:
    """Return the type that a column of numbers is written as: one that holds its every value."""
    if column.dtype.kind == "f":
        return "f8"
    return "u8" if column.dtype == np.uint64 else "i8"


def beside(parts: Sequence[Part], count: int) -> Bytes:
    """Return constants, numbers and text side by side, for this many rows."""
    if not count:
        return np.empty((0, 1), dtype=np.uint8)
    prefix = ""
    cells: list[tuple[str, str, NDArray[np.generic]]] = []  # kind, text before, what comes then
    for part in parts:
        if isinstance(part, str):
            prefix += part
        else:
            cells.append(("text" if part.ndim == 2 else _kind(part), prefix, part))
            prefix = ""
    columns: list[Bytes] = []
    for kind, group in groupby(cells, key=lambda cell: cell[0]):
        _, prefixes, values = zip(*group, strict=True)
        if kind == "text":
            for before, text in zip(prefixes, values, strict=True):
                columns += [_constant(before, count), text.view(np.uint8)]
        else:
            columns.append(_numbers(prefixes, values, kind))
    return np.concatenate([*columns, _constant(prefix, count)], axis=1)


def _constant(text: str, count: int) -> Bytes:
    encoded = np.frombuffer(text.encode(), dtype=np.uint8)
    return np.broadcast_to(encoded, (count, len(encoded)))


def as_list(column: NDArray[np.generic]) -> list[Part]:
    """Return the parts that write rows of an array as Python lists."""
    parts: list[Part] = ["["]
    for index in range(column.shape[1]):
        parts += [", " if index else "", column[:, index]]
    return [*parts, "]"]


def text_of(matrix: Bytes) -> bytes:
    """Return the text of all rows, one after the other."""
    return matrix.tobytes().translate(None, b"\0")


def lines_of(matrix: Bytes) -> list[bytes]:
    """Return the text of each row."""
    text = text_of(matrix)
    stops = np.cumsum(np.count_nonzero(matrix, axis=1)).tolist()
    return [text[start:stop] for start, stop in zip([0, *stops], stops, strict=False)]
