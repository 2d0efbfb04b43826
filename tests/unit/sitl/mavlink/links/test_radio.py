"""A failing signal spoils what goes either way, and only while it fails."""

from typing import Any

import pytest

from sitl.mavlink.wire.dialect import mavlink
from sitl.mavlink.wire.packets import Received
from sitl.records.failures import FailureType
from tests.unit.sitl.mavlink.bench import Bench


def ping(number: int) -> Any:
    return mavlink.MAVLink_ping_message(0, number, 0, 0)


def pongs(received: list[Received]) -> list[int]:
    own = [item.message for item in received if item.message.get_type() == "PING"]
    return [message.seq for message in own if message.target_system != 0]


def test_a_signal_of_noise_carries_nothing_either_way(bench: Bench) -> None:
    bench.vehicle.signal_fault = FailureType.GARBAGE
    bench.run(2)
    bench.gcs.take()
    bench.gcs.send(ping(1))
    bench.handle()
    bench.run(250)
    assert bench.gcs.take() == []
    bench.vehicle.signal_fault = FailureType.OK
    bench.run(250)
    assert bench.gcs.take() != []
    bench.gcs.send(ping(2))
    bench.handle()
    assert pongs(bench.gcs.take()) == [2]


def test_a_late_signal_is_half_a_second_late_each_way(bench: Bench) -> None:
    bench.vehicle.signal_fault = FailureType.DELAYED
    bench.run(2)
    bench.gcs.take()
    bench.gcs.send(ping(7))
    bench.handle()
    bench.run(120)
    assert bench.gcs.take() == []
    bench.run(120)
    assert pongs(bench.gcs.take()) == []
    bench.run(16)
    assert pongs(bench.gcs.take()) == [7]
    bench.vehicle.signal_fault = FailureType.OK
    bench.run(2)
    bench.gcs.send(ping(8))
    bench.handle()
    assert pongs(bench.gcs.take()) == [8]  # at once, though older words are still under way
    bench.run(126)
    assert all(link.radio is None for link in bench.links)


def test_a_slow_signal_carries_a_tenth(bench: Bench) -> None:
    bench.run(500)
    usual = len(bench.gcs.take())
    bench.vehicle.signal_fault = FailureType.SLOW
    bench.run(500)
    assert len(bench.gcs.take()) == pytest.approx(usual / 10, rel=0.3)
