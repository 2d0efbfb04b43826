"""What a user brings reaches another process: by its name, or in a file."""

import subprocess
import sys
from pathlib import Path

import pytest

from flightstack import extensions
from flightstack.errors import UsageError
from flightstack.launch.brought import name_of
from tests.paths import ROOT

READS = """
import sys
from flightstack import extensions
pilot = extensions.make(extensions.PILOT, sys.argv[1], direction="cw", seed=3)
print(pilot.act(None))
"""


class Straight:
    """Importable."""

    def __init__(self, *, direction: str, seed: int) -> None:
        self.seed, self.direction = seed, direction

    def reset(self) -> None:
        """Remember nothing."""

    def act(self, _: object) -> tuple[int, str]:
        return self.seed, self.direction


def test_a_name_is_a_name(tmp_path: Path) -> None:
    assert name_of("my_package:make", tmp_path / "pilot") == "my_package:make"
    assert name_of(Straight, tmp_path / "pilot") == f"{__name__}:Straight"
    assert list(tmp_path.iterdir()) == []


def test_what_no_name_leads_to_travels_in_a_file(tmp_path: Path) -> None:
    class Local(Straight):
        def act(self, _: object) -> tuple[int, str]:
            return 10 * self.seed, self.direction

    Local.__module__ = "__main__"  # as in a notebook: cloudpickle takes its code along
    name = name_of(Local, tmp_path / "pilot")
    assert name == str(tmp_path / "pilot.pickle")
    assert extensions.is_extension(extensions.PILOT, name)
    read = subprocess.run(
        [sys.executable, "-c", READS, name], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert read.stdout == "(30, 'cw')\n", read.stderr


def test_what_is_no_factory_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"^pilot: expected a factory or its name, got 7"):
        name_of(7, tmp_path / "pilot")  # type: ignore[arg-type]


def test_what_cannot_be_pickled_is_refused_in_one_line(tmp_path: Path) -> None:
    held = (number for number in range(3))
    with pytest.raises(UsageError, match="cannot be pickled") as refusal:
        name_of(lambda **_: held, tmp_path / "pilot")
    assert "\n" not in str(refusal.value)
