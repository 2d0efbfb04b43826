"""Rungs: every one that comes along can be flown, and a wrong one is one line."""

from pathlib import Path

import pytest

from flightstack.errors import UsageError
from flightstack.evaluation.trials.rungs import known_rungs, load_rung, parse_rung
from sitl.process.options.command_line import parse
from tests.paths import DOCS

FOG = """
about = "fog"
noise_m = [1.5, 3]
direction = "ccw"
command_factor = 1.6

[conditions.light]
fog_visibility_m = 12.0

[conditions.wind]
mean_ned_m_s = [3, 0, -0.5]
"""


def test_the_ladder_begins_with_the_papers_levels() -> None:
    assert known_rungs()[:2] == ["level1", "level2"]
    assert len(known_rungs()) == 19


@pytest.mark.parametrize("name", known_rungs())
def test_the_vehicle_understands_every_rung(name: str) -> None:
    rung, condition = load_rung(name)
    assert condition.name == name
    assert rung.about
    parse(condition.vehicle_options, {})


def test_a_rung_says_what_the_vehicle_is_told() -> None:
    rung, condition = parse_rung("bad-day", FOG)
    assert (rung.about, condition.noise_m, condition.direction) == ("fog", (1.5, 3.0), "ccw")
    assert condition.command_factor == 1.6
    told = parse(condition.vehicle_options, {}).conditions
    assert told.light.fog_visibility_m == 12.0
    assert told.wind.mean_ned_m_s == (3.0, 0.0, -0.5)


def test_a_rung_may_be_another_world() -> None:
    gate = (
        "[conditions.scenery]\ngate_colour_low = [0.0, 0.0, 0.6]\n"
        "gate_colour_high = [0.1, 0.2, 1.0]\n"
        "[conditions.scenery.gate]\noutline = 'circle'\ninner_m = 1.8\nouter_m = 2.2\n"
    )
    _, condition = parse_rung("rings", f"about = ''\nnoise_m = [1, 2]\n{gate}")
    scenery = parse(condition.vehicle_options, {}).conditions.scenery
    assert scenery.gate_colour_high == (0.1, 0.2, 1.0)
    told = scenery.gate
    assert (told.outline, told.inner_m, told.outer_m) == ("circle", 1.8, 2.2)


def test_a_rung_of_ones_own_is_named_by_its_path(tmp_path: Path) -> None:
    file = tmp_path / "bad-day.toml"
    file.write_text(FOG)
    _, condition = load_rung(str(file))
    assert condition.name == "bad-day"


@pytest.mark.parametrize(
    ("text", "fragments"),
    [
        ("about = 1\nnoise_m = [1.0, 2.0]", ["about", "str"]),
        ('about = ""', ["noise_m", "missing"]),
        ('about = ""\nnoise_m = [1.0]', ["noise_m", "2 numbers"]),
        ('about = ""\nnoise_m = [1.0, 2.0]\ndirection = "up"', ["direction", "'cw'"]),
        ('about = ""\nnoise_m = [1.0, -2.0]', ["noise_m", "from 0"]),
        ('about = ""\nnoise_m = [nan, 2.0]', ["noise_m", "expected float", "got nan"]),
        ('about = ""\nnoise_m = [9.0, 2.0]', ["noise_m", "to 4", "got 9.0"]),
        ('about = ""\nnoise_m = [1.0, inf]', ["noise_m", "expected float", "got inf"]),
        ('about = ""\nnoise_m = [1.0, 2.0]\ncommand_factor = 0.0', ["above 0"]),
        ('about = ""\nnoise_m = [1.0, 2.0]\ncommand_factor = nan', ["command_factor", "got nan"]),
        ('about = ""\nnoise_m = [1.0, 2.0]\ncommand_factor = inf', ["command_factor", "got inf"]),
        ('about = ""\nnoise_m = [1.0, 2.0]\nspeed = 2', ["unknown key 'speed'"]),
        ('about = ""\nnoise_m = [1.0, 2.0]\n[conditions.sea]', ["sea: unknown table", "wind"]),
        ("about =", ["Invalid value"]),
    ],
)
def test_a_wrong_rung_is_one_line(text: str, fragments: list[str]) -> None:
    with pytest.raises(UsageError) as refusal:
        parse_rung("bad-day", text)
    message = str(refusal.value)
    assert message.startswith("rung bad-day")
    assert "\n" not in message
    assert all(fragment in message for fragment in fragments)


@pytest.mark.parametrize("name", ["sea", "sea.toml"])
def test_an_unknown_rung_names_the_known_ones(name: str) -> None:
    with pytest.raises(UsageError, match=r"unknown rung 'sea.*level1, level2"):
        load_rung(name)


def test_the_document_shows_a_rung_as_it_may_be() -> None:
    document = DOCS / "training-and-evaluation.md"
    text = document.read_text()
    section = text.partition("### The ladder\n")[2]
    _, condition = parse_rung("document", section.split("```toml\n")[1].split("```")[0])
    assert condition.vehicle_options == ("--condition=camera.latency_s=0.1",)
    assert all(f"`{name}`" in text for name in known_rungs())
