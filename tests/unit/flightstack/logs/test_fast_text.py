import numpy as np
import pytest
from numpy.typing import NDArray

from flightstack.logs import fast_text


def texts(matrix: fast_text.Bytes) -> list[str]:
    return [bytes(row[row != 0]).decode() for row in matrix]


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
    assert texts(fast_text.from_numbers(floats)) == [str(x) for x in floats.tolist()]
    for kind in ("i1", "u1", "<i2", "<u2", "<i4", "<u4", "<i8", "<u8"):
        limits = np.iinfo(kind)
        values = np.array([limits.min, 0, 1, limits.max], dtype=kind)
        assert texts(fast_text.from_numbers(values)) == [str(x) for x in values.tolist()]


def test_doubles_look_as_str_writes_them() -> None:
    rng = np.random.default_rng(3)
    doubles = rng.normal(size=20_000) * 10.0 ** rng.integers(-15, 25, size=20_000)
    assert texts(fast_text.from_numbers(doubles)) == [str(x) for x in doubles.tolist()]


def test_without_orjson_numbers_look_the_same(monkeypatch: pytest.MonkeyPatch) -> None:
    floats = every_kind_of_float()[-5000:]
    monkeypatch.setattr(fast_text, "_joined", fast_text._joined_by_repr)
    assert texts(fast_text.from_numbers(floats)) == [str(x) for x in floats.tolist()]


def test_arrays_and_text_look_as_python_lists_and_strings() -> None:
    arrays = np.array([[1.5, 2.0], [np.nan, -3.0]], dtype=np.float32)
    assert texts(fast_text.from_column(arrays)) == ["[1.5, 2.0]", "[nan, -3.0]"]
    words = np.array(["Gate 1", "", "naïve \ufffd"])
    assert texts(fast_text.from_column(words)) == words.tolist()


def test_nothing_makes_no_lines() -> None:
    empty = fast_text.from_numbers(np.empty(0, dtype=np.float32))
    assert fast_text.text_of(fast_text.beside(["x ", empty], 0)) == b""
    assert fast_text.lines_of(fast_text.beside(["x ", empty], 0)) == []
