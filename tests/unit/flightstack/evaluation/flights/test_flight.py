"""What a flight's two processes leave behind tells deaths from errors that would come again."""

from pathlib import Path

import pytest

from flightstack.errors import UsageError
from flightstack.evaluation.flights.flight import TrialFlyer
from flightstack.evaluation.flights.reading import Provenance
from flightstack.evaluation.flights.warm import last_line
from flightstack.evaluation.trials import paper
from flightstack.evaluation.trials.experiment import Competitor, Trial

TRACEBACK = """Traceback (most recent call last):
  File "mine.py", line 7, in predict
    raise ValueError("no idea")
ValueError: no idea
"""
TRIAL = Trial(
    row=Competitor(name="mine.good", model="strong/m0", strategy="de-mean"),
    condition=paper.level("1"),
    track_seed=1000,
    trial=0,
    laps=1,
)
PROVENANCE = Provenance(experiment="benchmark", commit="", weights_sha256="")


class Ended:
    """A fork server whose flights end at once, the companion's with this exit code."""

    is_alive = True

    def __init__(self, code: int) -> None:
        self.code = code
        self.flights = 0

    def fly(self, order: dict[str, str]) -> dict[str, int | None]:
        self.flights += 1
        (Path(order["folder"]) / "companion.err").write_text(TRACEBACK)
        (Path(order["folder"]) / "companion.out").write_text("")
        return {"companion": self.code, "sitl": None}


def fly_into(server: Ended, monkeypatch: pytest.MonkeyPatch) -> tuple[str, ...]:
    launcher = TrialFlyer()
    monkeypatch.setattr(launcher, "_server", server)
    return launcher.fly(TRIAL, PROVENANCE).deaths


def test_an_exception_of_the_pilot_is_told_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    server = Ended(code=70)
    with pytest.raises(UsageError) as refusal:
        fly_into(server, monkeypatch)
    assert str(refusal.value) == (
        "mine.good-level1-1000-0 cannot be flown: who flies it raised ValueError: no idea"
    )
    assert server.flights == 1


def test_a_killed_pilot_flies_again(monkeypatch: pytest.MonkeyPatch) -> None:
    server = Ended(code=-9)
    assert (
        fly_into(server, monkeypatch) == ("the companion ended with -9: ValueError: no idea",) * 3
    )
    assert server.flights == 3


def test_a_librarys_banner_is_no_cause() -> None:
    banner = "pybullet build time: Nov 22 2026 10:00:00"
    assert last_line(f"out of memory\n{banner}\n\n") == "out of memory"
    assert last_line(f"{banner}\n") == "it said nothing"
    assert last_line("") == "it said nothing"
