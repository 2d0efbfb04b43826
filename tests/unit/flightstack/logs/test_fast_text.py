import numpy as np
import pytest
from numpy.typing import NDArray

from flightstack.logs import fast_text


def texts(matrix: fast_text.Bytes) -> list[str]:
    return [bytes(row[row != 0]).decode() for row in matrix]


def written(column: NDArray[np.generic]) -> list[str]:
    return texts(fast_text.beside([column], len(column)))


def every_kind_of_float() -> NDArray[np.float32]:
    rng = np.random.default_rng(2)
    bits = rng.integers(0, 2**32, size=60_000, dtype=np.uint64).astype(np.uint32)
    ordinary = rng.normal(size=20_000) * 10.0 ** rng.integers(-12, 20, size=20_000)
    round_ones = np.array([0, -0.0, 1, 0.5, 1e-4, 1e-5, 9.9e-5, 1e15, 1e16, 1e17, 2**24, 1e-45])
    small = [0.00001, 0.00002, -0.00003, 0.000012, 0.00009999]
    rest = np.concatenate([ordinary, round_ones, small]).astype(np.float32)
    return np.concatenate([bits.view(np.float32), rest])


def test_numbers_look_as_str_writes_them() -> None:
    floats = every_kind_of_float()
    assert written(floats) == [str(x) for x in floats.tolist()]
    for kind in ("i1", "u1", "<i2", "<u2", "<i4", "<u4", "<i8", "<u8"):
        limits = np.iinfo(kind)
        values = np.array([limits.min, 0, 1, limits.max], dtype=kind)
        assert written(values) == [str(x) for x in values.tolist()]


def test_doubles_look_as_str_writes_them() -> None:
    rng = np.random.default_rng(3)
    doubles = rng.normal(size=20_000) * 10.0 ** rng.integers(-15, 25, size=20_000)
    assert written(doubles) == [str(x) for x in doubles.tolist()]


def test_without_orjson_numbers_look_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    floats = every_kind_of_float()[-5000:]
    monkeypatch.setattr(fast_text, "_listed", fast_text._listed_by_repr)
    assert written(floats) == [str(x) for x in floats.tolist()]


def test_numbers_stand_behind_their_constants() -> None:
    rng = np.random.default_rng(4)
    small, large = rng.integers(0, 200, size=500).astype("u1"), rng.integers(-9, 9, size=500)
    one, other = rng.normal(size=(2, 500)).astype("f4")
    words = ["", "a", "naïve \ufffd"] * 166 + ["", "b"]
    parts: list[fast_text.Part] = ["<", small, large, "é", one, ", ", other]
    parts += [";", fast_text.from_texts(words), one, ">"]
    rows = zip(*(column.tolist() for column in (small, large, one, other)), words, strict=True)
    assert texts(fast_text.beside(parts, 500)) == [
        f"<{a}{b}é{c}, {d};{word}{c}>" for a, b, c, d, word in rows
    ]


def test_arrays_look_as_python_lists() -> None:
    arrays = np.array([[1.5, 2.0], [np.nan, -3.0]], dtype=np.float32)
    lines = fast_text.beside(fast_text.as_list(arrays), 2)
    assert texts(lines) == ["[1.5, 2.0]", "[nan, -3.0]"]
    assert fast_text.text_of(lines) == b"[1.5, 2.0][nan, -3.0]"
    assert fast_text.lines_of(lines) == [b"[1.5, 2.0]", b"[nan, -3.0]"]


def test_nothing_makes_no_lines() -> None:
    empty = fast_text.beside(["x ", np.empty(0, dtype=np.float32)], 0)
    assert fast_text.text_of(empty) == b""
    assert fast_text.lines_of(empty) == []
