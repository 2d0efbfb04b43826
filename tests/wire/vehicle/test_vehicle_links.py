"""Further links of a vehicle process, and the way from one link to another."""

import socket
import subprocess
import sys
from collections.abc import Callable, Iterator
from typing import Any

import pytest
from pymavlink import mavutil
from pymavlink.dialects.v20 import development as mavlink

from tests.paths import ROOT
from tests.wire.vehicle_process import OTHER_COMPONENT, OTHER_SYSTEM, Client, Vehicle

pytestmark = pytest.mark.flight
ONBOARD_CONTROLLER = 18


def free_tcp_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@pytest.fixture
def further() -> Iterator[Client]:
    client = Client()
    yield client
    client.close()


def test_four_links_speak_and_forward_to_each_other(further: Client) -> None:
    tcp_port = free_tcp_port()
    options = (f"--udp=127.0.0.1:{further.port}", f"--tcp={tcp_port}")
    with Vehicle(*options) as vehicle:
        vehicle.wait_until_up()
        further.wait_for("HEARTBEAT")
        tcp = mavutil.mavlink_connection(
            f"tcp:127.0.0.1:{tcp_port}", source_system=77, dialect="development"
        )
        assert tcp.wait_heartbeat(timeout=10.0) is not None
        tcp.mav.command_long_send(1, 1, 512, 0, 148, *[0.0] * 6)
        assert tcp.recv_match(type="AUTOPILOT_VERSION", blocking=True, timeout=10.0) is not None
        tcp.mav.heartbeat_send(ONBOARD_CONTROLLER, 8, 0, 0, 4)
        for client in (vehicle.gcs, vehicle.api, further):
            client.wait_for(lambda m: m.get_srcSystem() == 77, "the TCP client's HEARTBEAT")
        further.send(mavlink.MAVLink_ping_message(1, 5, 77, 0))
        assert tcp.recv_match(
            type="PING", condition="PING.target_system==77", blocking=True, timeout=10.0
        )
        tcp.close()
        code, said = vehicle.end(15)
    assert code == 0
    assert f"link 2 udp to 127.0.0.1:{further.port}, link 3 tcp {tcp_port}" in said


def test_whoever_speaks_first_is_a_links_partner_for_good(further: Client) -> None:
    """A later sender is obeyed, and hears nothing: what it gets goes to the first."""
    with Vehicle("-q") as vehicle:
        vehicle.wait_until_up()
        vehicle.gcs.say_hello()
        further.vehicle = vehicle.gcs.vehicle
        further.codec.srcSystem = 99
        further.command(512, 148)
        vehicle.gcs.wait_for("AUTOPILOT_VERSION")
        answer = vehicle.gcs.wait_for(
            lambda m: m.get_type() == "COMMAND_ACK" and m.target_system == 99, "its answer"
        )
        assert answer.result == 0
        vehicle.gcs.wait_for("HEARTBEAT")
        assert not list(further.messages(0.0))


def is_forwarded(name: str) -> Callable[[Any], bool]:
    """Make a condition: a message of that name from another client."""
    return lambda m: m.get_type() == name and m.get_srcSystem() == OTHER_SYSTEM


def test_what_ground_stations_ask_each_other_is_forwarded_as_they_sent_it() -> None:
    """HEARTBEAT, TIMESYNC and PING of a client appear on the other link, with its system id."""
    with Vehicle("-q") as vehicle:
        vehicle.wait_until_up()
        for here, there in ((vehicle.gcs, vehicle.api), (vehicle.api, vehicle.gcs)):
            here.say_hello(ONBOARD_CONTROLLER)
            here.send(mavlink.MAVLink_timesync_message(0, 5))
            here.send(mavlink.MAVLink_ping_message(1, 5, 0, 0))
            heartbeat, timesync, ping = (
                there.wait_for(is_forwarded(name), name)
                for name in ("HEARTBEAT", "TIMESYNC", "PING")
            )
            assert {m.get_srcComponent() for m in (heartbeat, timesync, ping)} == {OTHER_COMPONENT}
            assert heartbeat.type == ONBOARD_CONTROLLER
            assert (timesync.tc1, timesync.ts1) == (0, 5)
            assert (ping.time_usec, ping.seq, ping.target_system) == (1, 5, 0)


def test_a_port_in_use_is_refused_in_one_line() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_STREAM) as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        run = subprocess.run(
            [sys.executable, "-m", "sitl", "--gcs-link=0:9", "--api-link=0:9", f"--tcp={port}"],
            cwd=ROOT,
            capture_output=True,
            text=True,
            check=False,
        )
    assert run.returncode == 3
    assert run.stderr.splitlines() == [
        f"sitl: --tcp 127.0.0.1:{port}: is in use; choose another port"
    ]
