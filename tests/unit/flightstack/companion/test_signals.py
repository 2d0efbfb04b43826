"""Signals: at once before the flight, landing first in it, at once the second time."""

import signal

import pytest

from flightstack.companion.signals import StopSwitch, ending_at_once, landing_first


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_before_the_flight_a_signal_interrupts(number: signal.Signals) -> None:
    with ending_at_once(), pytest.raises(KeyboardInterrupt):
        signal.raise_signal(number)
    assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_in_flight_the_first_asks_and_the_second_interrupts(number: signal.Signals) -> None:
    stop = StopSwitch()
    with landing_first(stop):
        signal.raise_signal(number)
        assert stop.requested
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(number)
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler
