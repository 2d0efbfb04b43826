import logging

import pytest

from sitl.mavlink.wire.refusals import REPORT_S, Refusal, Refusals


def test_a_flood_costs_one_line_in_a_while(caplog: pytest.LogCaptureFixture) -> None:
    refusals = Refusals()
    refusals.report(0.0)
    assert not caplog.records
    for tick in range(1000):
        refusals.note([Refusal.UNSIGNED, Refusal.UNSIGNED, Refusal.NO_PACKET])
        refusals.report(tick * REPORT_S / 500.0)
    assert [record.getMessage() for record in caplog.records] == [
        "refused: 2 unsigned, 1 no valid packet",
        "refused: 1000 unsigned, 500 no valid packet",
    ]


def test_the_totals_are_told_at_the_end(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.INFO)
    refusals = Refusals()
    refusals.report_all()
    assert not caplog.records
    refusals.note([Refusal.REPLAYED])
    refusals.report_all()
    assert caplog.records[0].getMessage() == "refused in all: 1 replayed"


def test_what_may_be_a_mistake_is_no_warning(caplog: pytest.LogCaptureFixture) -> None:
    caplog.set_level(logging.INFO)
    refusals = Refusals()
    refusals.note([Refusal.COMMAND, Refusal.PARAMETER])
    refusals.report(0.0)
    refusals.note([Refusal.COMMAND, Refusal.NO_PACKET])
    refusals.report(REPORT_S)
    assert [record.levelname for record in caplog.records] == ["INFO", "WARNING"]
