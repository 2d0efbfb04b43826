"""A setpoint that gets lost is sent again: lockstep neither stops nor becomes another flight."""

from pathlib import Path

import pytest
from pymavlink.dialects.v20 import common

from flightstack.companion.mission.records import Outcome
from flightstack.launch.instances import API_PORT, free_instance
from tests.wire.companion.companion_trial import ForwardPilot, Trial, read_tlog
from tests.wire.companion.test_companion_with_vehicle import Vehicle, positions
from tests.wire.fake_vehicle import Script
from tests.wire.proxy import Proxy

pytestmark = pytest.mark.flight
SETPOINT = "SET_POSITION_TARGET_LOCAL_NED"
LOST = {0, 60, 240, 241}  # the first of all, one on the ground, two in flight


class LosesOnce:
    """Loses the setpoint of each of some images the first time that it is sent."""

    def __init__(self, numbers: set[int]) -> None:
        self.lost = 0
        self._numbers = numbers
        self._stamps_ms: list[int] = []
        self._parser = common.MAVLink(None)

    def __call__(self, datagram: bytes) -> list[bytes]:
        for message in self._parser.parse_buffer(datagram) or []:
            if message.get_type() != SETPOINT or message.time_boot_ms in self._stamps_ms:
                continue
            self._stamps_ms.append(message.time_boot_ms)
            if len(self._stamps_ms) - 1 in self._numbers:
                self.lost += 1
                return []
        return [datagram]


def fly_with_losses(log: Path, numbers: set[int]) -> None:
    """Fly straight on for 3 s."""
    loses = LosesOnce(numbers)
    with free_instance() as instance, Proxy(API_PORT + instance, to_vehicle=loses) as proxy:
        vehicle = Vehicle(instance, "--speed-factor=0", f"--api-link=0:{proxy.vehicle_port}")
        try:
            summary = vehicle.fly(log, ForwardPilot((1.5, 0, 0, 0)), duration_s=3.0)
        finally:
            vehicle.process.terminate()
            vehicle.process.wait(10)
    assert loses.lost == len(numbers)
    assert summary.outcome is Outcome.TIMEOUT
    assert summary.setpoints == summary.images


def test_a_lost_setpoint_is_sent_again_and_the_flight_is_the_same(tmp_path: Path) -> None:
    whole, lossy = tmp_path / "whole.tlog", tmp_path / "lossy.tlog"
    fly_with_losses(whole, set())
    fly_with_losses(lossy, LOST)
    track, lossy_track = ({row[0]: row for row in positions(log)} for log in (whole, lossy))
    both = set(track) & set(lossy_track)
    assert len(both) > 300
    assert all(track[stamp_ms] == lossy_track[stamp_ms] for stamp_ms in both)
    stamps_ms = [m.time_boot_ms for m in read_tlog(lossy) if m.get_type() == SETPOINT]
    repeated = {stamp for stamp in stamps_ms if stamps_ms.count(stamp) > 1}
    assert len(repeated) == len(LOST)
    assert max(map(stamps_ms.count, repeated)) == 2


def test_a_silent_vehicle_is_not_kept_in_offboard(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script(gates=None, silent_after=30), reach_s=3.0)
    assert trial.fly().outcome is Outcome.LINK_LOST
    stamps_ms = [setpoint.time_boot_ms for setpoint in trial.vehicle.setpoints()]
    assert len(stamps_ms) == len(set(stamps_ms))
