"""A share of `scripts/bench/hostile.py`: the flight under attack is the flight without it."""

import pytest

from scripts.bench import hostile

pytestmark = pytest.mark.flight
DATAGRAMS = 20_000


@pytest.mark.parametrize("signed", [False, True], ids=["without a key", "with a key"])
def test_an_attack_makes_no_difference(
    signed: bool,  # noqa: FBT001
    capsys: pytest.CaptureFixture[str],
) -> None:
    key = ["--signed"] if signed else []
    code = hostile.main([f"--datagrams={DATAGRAMS}", "--laps=1", *key])
    said = capsys.readouterr().out
    assert code == 0, said
    assert "harm: none" in said
    assert "gates 8 of 8" in said


def test_memory_that_grows_is_harm() -> None:
    flat, grown = (
        hostile.Flight(vehicle_code=0, rss_before_kb=100_000, rss_after_kb=after_kb)
        for after_kb in (104_900, 105_100)
    )
    assert hostile.judge(flat, flat) == []
    assert hostile.judge(grown, flat) == ["resident memory grew from 100000 to 105100 kB"]
