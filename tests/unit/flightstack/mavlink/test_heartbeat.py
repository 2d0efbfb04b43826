"""The companion's heartbeat, on either clock."""

from typing import Any

from flightstack.mavlink.heartbeat import HeartbeatSender
from tests.unit.flightstack.mavlink.made_link import Wall


def test_beats_once_a_second_of_vehicle_time() -> None:
    sent: list[Any] = []
    sender = HeartbeatSender(sent.append, Wall())
    for vehicle_us in range(0, 3_000_001, 50_000):
        sender.send_if_due(vehicle_us)
    assert len(sent) == 4
    assert {(beat.type, beat.autopilot, beat.system_status) for beat in sent} == {(18, 8, 4)}


def test_beats_by_the_wall_while_the_vehicles_clock_stands_still() -> None:
    sent: list[Any] = []
    wall = Wall()
    sender = HeartbeatSender(sent.append, wall)
    for _ in range(61):
        sender.send_if_due(0)
        wall.now_s += 0.1
    assert len(sent) == 6
