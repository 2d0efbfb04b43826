"""Both sides under one key: they fly as without, and whoever lacks the key changes nothing."""

import hashlib
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pymavlink.dialects.v20 import common

from flightstack.companion.mission.records import Outcome
from flightstack.errors import LinkError
from flightstack.launch.instances import API_PORT, free_instance
from flightstack.mavlink.packets import is_signed
from tests.wire.companion.companion_trial import ForwardPilot, Trial, read_tlog
from tests.wire.companion.test_companion_with_vehicle import Vehicle, positions
from tests.wire.fake_vehicle import Script
from tests.wire.proxy import Proxy, unchanged

KEY, OTHER_KEY = (hashlib.sha256(word).digest() for word in (b"ours", b"theirs"))
FAR_FUTURE = (1 << 48) - 1
POSITION_MODE = 0x00030000
KEPT = 200  # datagrams from which replays are taken


def test_flies_signed_as_unsigned(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script(signing_key=KEY), signing_key=KEY)
    summary = trial.fly()
    assert (summary.outcome, summary.gates_passed) == (Outcome.COMPLETED, 3)
    assert all(m.get_signed() for m in trial.vehicle.received)  # and the signatures are right
    assert all(is_signed(bytes(m.get_msgbuf())) for m in read_tlog(trial.plan.log))
    assert "refused" not in trial.output.getvalue()


def test_a_vehicle_whose_clock_stood_still_is_told_the_time(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script(signing_key=KEY, signing_lag_s=86_400.0), signing_key=KEY)
    assert trial.fly().outcome is Outcome.COMPLETED
    first = trial.vehicle.received[0]
    assert (first.get_type(), first.get_srcComponent()) == ("HEARTBEAT", 191)
    assert "stamped more than a minute ago" in trial.output.getvalue()


def test_a_vehicle_of_another_key_is_told(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script(signing_key=OTHER_KEY), signing_key=KEY, timeout_s=1.0)
    with pytest.raises(LinkError, match="what came was refused: not signed with our key"):
        trial.fly()


def test_a_vehicle_without_key_is_told(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script(has_camera=False), signing_key=KEY, timeout_s=1.0)
    with pytest.raises(LinkError, match="what came was refused: not signed"):
        trial.fly()


def test_a_companion_without_key_is_told(tmp_path: Path) -> None:
    trial = Trial(tmp_path, Script(signing_key=KEY), timeout_s=1.0)
    with pytest.raises(LinkError, match="named no camera"):  # it does not heed our question
        trial.fly()
    assert "the vehicle signs its messages" in trial.output.getvalue()


def source(component: int, key: bytes | None = None) -> common.MAVLink:
    """Make one who signs with a key, far ahead in time, or one who does not sign."""
    end = common.MAVLink(None, 1, component)
    end.signing.secret_key = key
    end.signing.sign_outgoing = key is not None
    end.signing.timestamp = FAR_FUTURE - 1_000_000
    return end


class Attacker:
    """Adds to each datagram a lie, forged or unsigned, or a replay; all by a seeded generator."""

    def __init__(self, lies: list[tuple[int, Any]]) -> None:
        self.sent: Counter[str] = Counter()
        self._rng = np.random.default_rng(0)
        self._kept: list[bytes] = []
        self._lies = [
            (kind, message, source(component, key))
            for component, message in lies
            for kind, key in (("unsigned", None), ("forged", OTHER_KEY))
        ]

    def __call__(self, datagram: bytes) -> list[bytes]:
        self._kept = [*self._kept[-KEPT:], datagram]
        if self._rng.random() < 0.3:
            self.sent["replayed"] += 1
            return [datagram, self._kept[self._rng.integers(len(self._kept))]]
        kind, message, end = self._lies[self._rng.integers(len(self._lies))]
        self.sent[kind] += 1
        return [bytes(message.pack(end)), datagram]


def lies_to_vehicle() -> list[tuple[int, Any]]:
    velocity = (0, 1, 1, 8, 0x5C7, 0.0, 0.0, 0.0, -3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    kill = (1, 1, 400, 0, 0.0, 21196.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    hold = (1, 1, 176, 0, 1.0, 4.0, 3.0, 0.0, 0.0, 0.0, 0.0)
    return [
        (191, common.MAVLink_set_position_target_local_ned_message(*velocity)),
        (191, common.MAVLink_command_long_message(*kill)),
        (190, common.MAVLink_command_long_message(*hold)),
        (191, common.MAVLink_param_set_message(1, 1, b"MPC_XY_VEL_MAX", 0.1, 9)),
        (190, common.MAVLink_setup_signing_message(1, 1, list(OTHER_KEY), 0)),
    ]


def lies_to_companion() -> list[tuple[int, Any]]:
    return [
        (1, common.MAVLink_heartbeat_message(2, 12, 81, POSITION_MODE, 3, 3)),
        (1, common.MAVLink_extended_sys_state_message(0, 1)),
        (1, common.MAVLink_attitude_message(4_000_000_000, 0, 0, 0, 0, 0, 0)),
        (25, common.MAVLink_statustext_message(4, b"Missed gate 1: 2.1 m right")),
        (25, common.MAVLink_mission_current_message(8, 8, 5)),
        (100, common.MAVLink_camera_trigger_message(3_000_000_000, 1)),
    ]


def fly(log: Path, key_file: Path, to_vehicle: Any, to_companion: Any) -> Outcome:
    hooks = {"to_vehicle": to_vehicle, "to_companion": to_companion}
    with free_instance() as instance, Proxy(API_PORT + instance, **hooks) as proxy:
        options = (f"--api-link=0:{proxy.vehicle_port}", f"--signing-key={key_file}")
        vehicle = Vehicle(instance, "--speed-factor=0", *options)
        try:
            pilot = ForwardPilot((1.5, 0, 0, 0))
            return vehicle.fly(log, pilot, duration_s=3.0, signing_key=KEY).outcome
        finally:
            vehicle.process.terminate()
            vehicle.process.wait(10)


@pytest.mark.flight
def test_an_attacker_in_the_middle_without_the_key_changes_no_bit_of_the_flight(
    tmp_path: Path,
) -> None:
    key_file = tmp_path / "key"
    key_file.write_text(KEY.hex())
    calm, attacked = tmp_path / "calm.tlog", tmp_path / "attacked.tlog"
    assert fly(calm, key_file, unchanged, unchanged) is Outcome.TIMEOUT
    attackers = Attacker(lies_to_vehicle()), Attacker(lies_to_companion())
    assert fly(attacked, key_file, *attackers) is Outcome.TIMEOUT
    assert min(min(attacker.sent.values()) for attacker in attackers) > 100
    track, attacked_track = ({row[0]: row for row in positions(log)} for log in (calm, attacked))
    both = set(track) & set(attacked_track)
    assert len(both) > 300
    assert all(track[stamp_ms] == attacked_track[stamp_ms] for stamp_ms in both)
    assert 4_000_000_000 not in {m.time_boot_ms for m in read_tlog(attacked) if is_attitude(m)}


def is_attitude(message: Any) -> bool:
    return bool(message.get_type() == "ATTITUDE")
