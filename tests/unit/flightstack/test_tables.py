"""TOML becomes a record, or one line that names the key."""

import math
from dataclasses import dataclass

import pytest

from flightstack.tables import read_toml, record_from_table, table_text


@dataclass(frozen=True)
class Inner:
    share: float = 0.5


@dataclass(frozen=True)
class Outer:
    name: str
    tilt_rad: float = 0.0
    range_m: tuple[float, float] = (1.0, 2.0)
    counts: tuple[int, ...] = ()
    inner: Inner | None = None


def record(text: str) -> Outer:
    return record_from_table(Outer, read_toml(text, where="file"), where="file")


def test_a_record_is_read_as_it_was_written() -> None:
    outer = Outer(name="a", tilt_rad=0.5, counts=(1, 2), inner=Inner(share=0.25))
    assert record(table_text(outer)) == outer


def test_degrees_fill_a_field_in_radians() -> None:
    assert record('name = "a"\ntilt_deg = 90').tilt_rad == math.radians(90.0)


def test_what_is_given_may_not_be_in_the_table() -> None:
    given = {"inner": Inner()}
    assert record_from_table(Outer, {"name": "a"}, where="file", given=given).inner == Inner()
    with pytest.raises(ValueError, match="file: unknown key 'inner'"):
        record_from_table(Outer, {"name": "a", "inner": {}}, where="file", given=given)


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("name =", "file: not TOML: Invalid value"),
        ("", "file: 'name' is missing"),
        ('name = "a"\nsize = 1', "file: unknown key 'size'; known are name, tilt_rad"),
        ("name = 1", "file.name: expected str, got 1"),
        ('name = "a"\ntilt_deg = nan', "file.tilt_deg: expected float, got nan"),
        ('name = "a"\nrange_m = [1]', r"file.range_m: expected 2 numbers, got \[1\]"),
        ('name = "a"\ncounts = [1.5]', "file.counts: expected int, got 1.5"),
        ('name = "a"\ninner = 1', "file.inner: expected a table, got 1"),
        ('name = "a"\n[inner]\nshare = "all"', "file.inner.share: expected float, got 'all'"),
    ],
)
def test_a_wrong_table_is_one_line(text: str, complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        record(text)
