"""What a flight's two processes leave behind tells deaths from errors that would come again."""

import pytest

from flightstack.errors import UsageError
from flightstack.evaluation.flights.flight import TrialFlyer
from flightstack.evaluation.flights.reading import Provenance
from flightstack.evaluation.trials import paper
from flightstack.evaluation.trials.experiment import Competitor, Trial
from flightstack.launch.order import Ended, Order

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


class EndsAtOnce:
    """A starter whose flights end at once, the companion's with this exit code."""

    def __init__(self, code: int) -> None:
        self.code = code
        self.flights = 0

    def prepare(self) -> None:
        pass

    def fly(self, order: Order) -> Ended:
        self.flights += 1
        (order.folder / "companion.err").write_text(TRACEBACK)
        return Ended(vehicle=None, companion=self.code, folder=order.folder)

    def close(self) -> None:
        pass


def deaths_by(starter: EndsAtOnce) -> tuple[str, ...]:
    return TrialFlyer(starter).fly(TRIAL, PROVENANCE).deaths


def test_an_exception_of_the_pilot_is_told_at_once() -> None:
    starter = EndsAtOnce(code=1)
    with pytest.raises(UsageError) as refusal:
        deaths_by(starter)
    assert str(refusal.value) == (
        "mine.good-level1-1000-0 cannot be flown: the companion raised ValueError: no idea"
    )
    assert starter.flights == 1


def test_a_killed_pilot_flies_again() -> None:
    starter = EndsAtOnce(code=-9)
    assert deaths_by(starter) == ("the companion ended with -9: ValueError: no idea",) * 3
    assert starter.flights == 3
