import math
from dataclasses import asdict
from pathlib import Path

import pytest

from sitl.errors import UsageError
from sitl.records.conditions import Conditions, read_conditions
from tests.paths import DOCS

EVERYTHING = """
[wind]
mean_ned_m_s = [3.0, -1, 0.5]
gust_std_m_s = 1.0
gust_time_constant_s = 4.0

[light]
fog_visibility_m = 12.0
daylight_share = 0.5

[camera]
latency_s = 0.1
blur_std_px = 2.0
noise_std_levels = 20.0
frozen_frame_share = 0.25

[course]
decoy_inwards_m = 2.4
"""


def test_without_a_file_the_day_is_fine() -> None:
    assert read_conditions(None) == Conditions()


def test_a_file_sets_what_it_names(tmp_path: Path) -> None:
    file = tmp_path / "bad-day.toml"
    file.write_text(EVERYTHING)
    conditions = read_conditions(file)
    assert conditions.wind.mean_ned_m_s == (3.0, -1.0, 0.5)
    assert (conditions.wind.gust_std_m_s, conditions.wind.gust_time_constant_s) == (1.0, 4.0)
    assert (conditions.light.fog_visibility_m, conditions.light.daylight_share) == (12.0, 0.5)
    assert (conditions.camera.latency_s, conditions.camera.blur_std_px) == (0.1, 2.0)
    assert conditions.camera.noise_std_levels == 20.0
    assert conditions.camera.frozen_frame_share == 0.25
    assert conditions.course.decoy_inwards_m == 2.4
    file.write_text("[camera]\nlatency_s = 0.2\n")
    assert read_conditions(file).wind == Conditions().wind


def test_a_change_goes_before_the_file_and_leaves_the_rest(tmp_path: Path) -> None:
    file = tmp_path / "bad-day.toml"
    file.write_text(EVERYTHING)
    changed = read_conditions(file, ["camera.latency_s=0.2", "light.fog_visibility_m=inf"])
    assert (changed.camera.latency_s, changed.camera.blur_std_px) == (0.2, 2.0)
    assert math.isinf(changed.light.fog_visibility_m)
    assert changed.light.daylight_share == 0.5


def test_changes_of_one_gate_add_up() -> None:
    changes = ["scenery.gate={inner_m = 1.8, outer_m = 2.2}", "scenery.gate.outline='circle'"]
    gate = read_conditions(None, changes).scenery.gate
    assert (gate.outline, gate.inner_m, gate.outer_m) == ("circle", 1.8, 2.2)


@pytest.mark.parametrize(
    ("change", "fragments"),
    [
        ("camera.lag_s=1", ["camera.lag_s", "unknown key", "latency_s"]),
        ("lens.dirt=1", ["lens", "unknown table", "camera"]),
        ("camera=1", ["camera", "must be a table"]),
        ("camera.latency_s=0.5", ["latency_s", "0 to 0.4", "0.5"]),
        ("camera.latency_s=true", ["latency_s", "a number", "True"]),
        ("light.fog_visibility_m=nan", ["fog_visibility_m", "nan"]),
        ("wind.mean_ned_m_s=3", ["mean_ned_m_s", "3 numbers"]),
        ("wind.mean_ned_m_s=[1, 2]", ["mean_ned_m_s", "3 numbers", "[1, 2]"]),
        ("wind.mean_ned_m_s=[1, 2, 99]", ["mean_ned_m_s", "-20 to 20", "99"]),
        ("course.decoy_inwards_m=1.0", ["decoy_inwards_m", "at least 1.8"]),
        ("scenery.gate.outline='star'", ["outline", "one of square, circle", "'star'"]),
        ("scenery.gate.inner_m=9", ["inner_m", "0.4 to 4"]),
        ("scenery.gate.inner_m=1.8", ["outer_m", "above inner_m, 1.8, got 1.6"]),
        ("scenery.gate_pictures='a.png'", ["gate_pictures", "must be a list", "'a.png'"]),
        ("scenery.gate_pictures=[1]", ["gate_pictures", "must be a text, got 1"]),
        ("scenery.gate_colour_low=[1, 1, 1]", ["gate_colour_high", "must lie in order"]),
        ("latency", ["not TOML"]),
    ],
)
def test_what_cannot_be_is_one_line_that_says_what_could(change: str, fragments: list[str]) -> None:
    with pytest.raises(UsageError) as refusal:
        read_conditions(None, [change])
    text = str(refusal.value)
    assert "\n" not in text
    assert all(fragment in text for fragment in [change, *fragments])


def test_a_file_that_is_not_one_is_named(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="can't read"):
        read_conditions(tmp_path / "missing.toml")
    file = tmp_path / "wrong.toml"
    file.write_text("[camera]\nlag_s = 1\n")
    with pytest.raises(UsageError, match=r"wrong\.toml: camera\.lag_s: unknown key"):
        read_conditions(file)


def test_the_document_shows_every_key_as_it_may_be(tmp_path: Path) -> None:
    document = DOCS / "conditions.md"
    example = document.read_text().split("```toml\n")[1].split("```")[0]
    file = tmp_path / "document.toml"
    file.write_text(example)
    conditions = read_conditions(file)
    for name, part in asdict(conditions).items():
        plain = part.pop("gate", {}) | part
        assert all(f"{key} = " in example for key in plain), name
    assert conditions != Conditions()
