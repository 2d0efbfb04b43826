import numpy as np
import pytest
from numpy.typing import NDArray

from flightstack.logs.text import fast_text


def texts(lines: fast_text.Lines) -> list[str]:
    return [line.decode() for line in fast_text.lines_of(lines)]


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


def test_lines_of_constants_only_are_lines() -> None:
    stamps = fast_text.from_texts(["ab", "cd"])
    assert texts(fast_text.beside([stamps, ": NOTHING {}\n"], 2)) == [
        "ab: NOTHING {}\n",
        "cd: NOTHING {}\n",
    ]


@pytest.mark.parametrize("seed", range(20))
def test_any_parts_side_by_side_look_as_they_do_alone(seed: int) -> None:
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 40))
    bits = rng.integers(0, 2**32, size=(8, count), dtype=np.uint64)
    words = [["", "x", "a longer word than a number has", "\0", "\u03c0"][n] for n in bits[0] % 5]
    alike = [f"{n:02d}" for n in (bits[1] % 100).tolist()]
    columns: list[tuple[fast_text.Part, list[str]]] = [
        (fast_text.from_texts(words), [word.replace("\0", "") for word in words]),
        (fast_text.from_texts(alike), alike),
        (" : ", [" : "] * count),
        ("", [""] * count),
    ]
    wide = bits[3] << np.uint64(32) | bits[4]
    numbers = [bits[2].astype(kind) for kind in ("u1", "<i2", "<u4")]
    numbers += [wide, wide.view(np.float64), bits[5].astype(np.uint32).view(np.float32)]
    columns += [(column, list(map(str, column.tolist()))) for column in numbers]
    chosen = [columns[index] for index in rng.integers(0, len(columns), size=8).tolist()]
    lines = texts(fast_text.beside([part for part, _ in chosen], count))
    assert lines == ["".join(row) for row in zip(*(each for _, each in chosen), strict=True)]
