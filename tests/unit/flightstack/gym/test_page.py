"""What docs/gymnasium.md says can be done, and is so."""

import inspect
import re
from typing import Any

import numpy as np

from flightstack.gym import GatesEnv
from flightstack.gym.gates import velocities_of
from flightstack.gym.scoring import GATE_LIMIT_S, MIN_HEIGHT_M
from tests.paths import DOCS

PAGE = (DOCS / "gymnasium.md").read_text()


def test_the_first_example_runs() -> None:
    block = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)[0]
    names: dict[str, Any] = {}
    exec(compile(block.replace("range(100)", "range(3)"), "gymnasium.md", "exec"), names)  # noqa: S102
    assert names["env"].observation_space.contains(names["observation"])
    assert np.isfinite(names["reward"])


def test_ranges_and_limits_are_those_of_the_page() -> None:
    low, high = velocities_of(-np.ones(4)), velocities_of(np.ones(4))
    for name, least, most in zip(("forward", "right", "down", "yaw rate"), low, high, strict=True):
        assert re.search(rf"\| {name} \| {least:g} \S+ \| {most:g} \S+ \|", PAGE), name
    assert f"less than {MIN_HEIGHT_M:g} m above the ground" in PAGE
    assert f"no gate passed for {GATE_LIMIT_S:g} s" in PAGE


def test_each_option_is_on_the_page() -> None:
    options = inspect.getfullargspec(GatesEnv.__init__).kwonlyargs
    assert set(re.findall(r"^\| `(\w+)` \| .*? \|", PAGE, re.MULTILINE)) >= set(options)
