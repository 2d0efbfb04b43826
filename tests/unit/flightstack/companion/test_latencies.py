"""Latencies are kept whole while they are few, and evenly for ever after."""

import numpy as np
import pytest

from flightstack.companion import latencies as module
from flightstack.companion.latencies import Latencies


def test_a_short_flight_keeps_every_one() -> None:
    kept = Latencies()
    for k in range(1000):
        kept.append(k / 1000)
    assert list(kept) == [k / 1000 for k in range(1000)]
    assert len(kept) == 1000


def test_a_flight_without_end_keeps_as_many_as_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MAX_KEPT", 100)
    kept = Latencies()
    for k in range(10_000):
        kept.append(k / 10_000)
        assert sum(1 for _ in kept) <= 101
    assert len(kept) == 10_000
    assert np.percentile(list(kept), 50) == pytest.approx(0.5, abs=0.05)
    assert np.percentile(list(kept), 99) == pytest.approx(0.99, abs=0.05)
