"""Write columns as text without a Python step a value.

A text column is a matrix of bytes, one row a value, padded with NUL. Columns and constant pieces
are laid side by side, and all NULs dropped at once: what is left is the text of all lines. Numbers
look as `str` writes them; orjson writes them fifteen times faster, where it is installed and where
it agrees with `str`.
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

Bytes = NDArray[np.uint8]  # (n, width) text, padded with NUL
ONE_DIGIT = (1e-10, 1e-5)  # between these orjson writes e-7 where `str` writes e-07
NO_EXPONENT = (1e-5, 1e-4)  # between these orjson writes no exponent, but `str` does


def _joined_by_repr(values: NDArray[np.generic]) -> bytes:
    return ",".join(map(repr, values.tolist())).encode()


def _find_joiner() -> Callable[[NDArray[np.generic]], bytes]:
    try:
        import orjson  # noqa: PLC0415
    except ImportError:
        return _joined_by_repr

    def joined(values: NDArray[np.generic]) -> bytes:
        return orjson.dumps(values, option=orjson.OPT_SERIALIZE_NUMPY)[1:-1]

    return joined


_joined = _find_joiner()


def from_pieces(text: bytes, starts: NDArray[np.int64], lengths: NDArray[np.int64]) -> Bytes:
    """Return pieces of a text as a matrix."""
    width = max(int(lengths.max(initial=0)), 1)
    padded = np.frombuffer(text + bytes(width), dtype=np.uint8)
    every_row = np.ndarray((len(padded) - width + 1,), f"V{width}", buffer=padded, strides=(1,))
    matrix = every_row[starts].view(np.uint8).reshape(len(starts), width)
    matrix[np.arange(width) >= lengths[:, None]] = 0
    return matrix


def from_bytes(values: Sequence[bytes]) -> Bytes:
    """Return byte strings as a matrix; NULs in them are lost."""
    array = np.array(list(values), dtype=np.bytes_)
    return (
        array.view(np.uint8).reshape(len(array), -1) if len(array) else np.empty((0, 1), np.uint8)
    )


def from_texts(values: Sequence[str]) -> Bytes:
    """Return strings as a matrix, UTF-8."""
    return from_bytes([value.encode(errors="replace") for value in values])


def from_numbers(column: NDArray[np.generic]) -> Bytes:
    """Return numbers as `str` writes them, as a matrix; 32-bit floats as the doubles they are."""
    if not len(column):
        return np.empty((0, 1), dtype=np.uint8)
    if column.dtype.kind != "f":
        wide = column.astype(np.uint64 if column.dtype.kind == "u" else np.int64)
        return _split(_joined(wide))
    with np.errstate(invalid="ignore"):  # signalling NaNs of damaged floats
        values = column.astype(np.float64)
    finite = np.isfinite(values)
    matrix = _split(_joined(values if finite.all() else np.where(finite, values, 0.0)))
    size = np.abs(values)
    for (least, most), rewrite in REWRITTEN:
        rows = np.flatnonzero((size >= least) & (size < most))
        if len(rows):
            matrix = _with_rows(matrix, rows, rewrite(matrix[rows]))
    special = np.flatnonzero(~finite)
    if len(special):
        words = from_texts(["nan", "inf", "-inf"])
        which = np.where(np.isnan(values[special]), 0, np.where(values[special] > 0, 1, 2))
        matrix = _with_rows(matrix, special, words[which])
    return matrix


def _with_rows(matrix: Bytes, rows: NDArray[np.intp], new: Bytes) -> Bytes:
    """Return the matrix with other rows in some places, wider if they need it."""
    if new.shape[1] > matrix.shape[1]:
        matrix = np.pad(matrix, ((0, 0), (0, new.shape[1] - matrix.shape[1])))
    matrix[rows] = 0
    matrix[rows, : new.shape[1]] = new
    return matrix


def _with_exponent(matrix: Bytes) -> Bytes:
    """Return 0.0000123 as 1.23e-05; rows that `repr` made already so stay as they are."""
    negative = matrix[:, 0] == ord("-")
    plain = np.where(negative[:, None], np.roll(matrix, -1, axis=1), matrix)
    if (plain[:, 1] != ord(".")).any() or (plain[:, 2] != ord("0")).any():
        return matrix
    sign = np.where(negative, ord("-"), 0).astype(np.uint8)[:, None]
    digits = plain[:, len("0.0000") :].copy()
    digits[negative, -1] = 0  # where the sign was rolled to
    point = np.where(digits[:, 1] != 0, ord("."), 0).astype(np.uint8)[:, None]
    return beside([sign, digits[:, :1], point, digits[:, 1:], "e-05"], len(matrix))


def _with_two_digits(matrix: Bytes) -> Bytes:
    """Return 1.23e-7 as 1.23e-07; rows that `repr` made already so stay as they are."""
    count = np.arange(len(matrix))
    last = np.count_nonzero(matrix, axis=1) - 1
    is_short = matrix[count, last - 1] == ord("-")
    digit = np.where(is_short, matrix[count, last], 0).astype(np.uint8)
    matrix[count[is_short], last[is_short]] = 0
    zero = np.where(is_short, ord("0"), 0).astype(np.uint8)
    return np.hstack((matrix, zero[:, None], digit[:, None]))


REWRITTEN = ((ONE_DIGIT, _with_two_digits), (NO_EXPONENT, _with_exponent))


def _split(joined: bytes) -> Bytes:
    """Return values that are joined by commas as a matrix."""
    flat = np.frombuffer(joined, dtype=np.uint8)
    ends = np.r_[np.flatnonzero(flat == ord(",")), len(flat)].astype(np.int64)
    starts = np.r_[0, ends[:-1] + 1]
    return from_pieces(joined, starts, ends - starts)


def from_column(column: NDArray[np.generic]) -> Bytes:
    """Return any column of a table: numbers, text, or arrays of numbers as Python lists."""
    if column.dtype.kind == "U":
        return from_texts(column.tolist())
    if column.ndim == 1:
        return from_numbers(column)
    count, length = column.shape
    cells = from_numbers(column.reshape(-1)).reshape(count, length, -1)
    parts: list[Bytes | str] = ["["]
    for index in range(length):
        parts += [cells[:, index], ", " if index + 1 < length else "]"]
    return beside(parts, count)


def beside(parts: Sequence[Bytes | str], count: int) -> Bytes:
    """Return columns and constant pieces side by side, for this many rows."""
    columns = []
    for part in parts:
        if isinstance(part, str):
            constant = np.frombuffer(part.encode(), dtype=np.uint8)
            columns.append(np.broadcast_to(constant, (count, len(constant))))
        else:
            columns.append(part)
    return np.concatenate(columns, axis=1)


def text_of(matrix: Bytes) -> bytes:
    """Return the text of all rows, one after the other."""
    return matrix.tobytes().translate(None, b"\0")


def lines_of(matrix: Bytes) -> list[bytes]:
    """Return the text of each row."""
    text = text_of(matrix)
    stops = np.cumsum(np.count_nonzero(matrix, axis=1)).tolist()
    return [text[start:stop] for start, stop in zip([0, *stops], stops, strict=False)]
