"""A vehicle with a signing key, over real sockets, with pymavlink at the other ends."""

from collections.abc import Iterator
from typing import Any

import pytest

from sitl.mavlink.endpoint import Endpoint
from sitl.mavlink.links.link import Guard
from sitl.mavlink.wire.dialect import mavlink
from sitl.mavlink.wire.refusals import Refusal
from sitl.mavlink.wire.signing import EPOCH_S, NO_KEY, UNITS_PER_S, Signing, make_clock
from tests.unit.sitl.mavlink.bench import FACTS, Peer, handle, link_to
from tests.unit.sitl.mavlink.fakes import FakeVehicle

KEY, OTHER_KEY = bytes(range(1, 33)), bytes(range(2, 34))
HEARTBEAT = mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3)


class Client(Peer):
    """pymavlink at the other end of a link; signs if it has a key."""

    def __init__(self) -> None:
        super().__init__()
        self.codec = mavlink.MAVLink(None, srcSystem=255, srcComponent=190)
        self.codec.robust_parsing = True

    def use(self, key: bytes | None) -> None:
        signing = self.codec.signing
        signing.secret_key, signing.sign_outgoing = key, key is not None
        signing.timestamp = max(signing.timestamp, make_clock()())

    def send(self, message: Any) -> bytes:
        raw = bytes(message.pack(self.codec))
        self.send_raw(raw)
        return raw

    def take(self) -> list[Any]:
        parse = self.codec.parse_buffer
        return [message for datagram in self.datagrams() for message in parse(datagram) or []]


class Bench:
    def __init__(self, key: bytes | None) -> None:
        self.vehicle = FakeVehicle()
        self.guard = Guard(signing=Signing(key))
        self.gcs, self.api = Client(), Client()
        self.links = [link_to(self.gcs, 0, self.guard), link_to(self.api, 1, self.guard)]
        self.endpoint = Endpoint(self.vehicle, self.links, system=1, camera=FACTS, guard=self.guard)

    def ask(self, client: Client, raw: bytes | None = None) -> list[int]:
        """Send a command, or something else instead; the answers on that link."""
        message = mavlink.MAVLink_command_long_message(1, 1, 400, 0, 1, *[0.0] * 6)
        if raw is None:
            client.send(message)
        else:
            client.send_raw(raw)
        self.handle()
        return [m.result for m in client.take() if m.get_type() == "COMMAND_ACK"]

    def handle(self) -> None:
        handle(self.endpoint, self.links)

    def hand_over(self, client: Client, key: bytes) -> None:
        stamp = make_clock()()
        client.send(mavlink.MAVLink_setup_signing_message(1, 1, list(key), stamp))
        self.handle()


@pytest.fixture
def bench() -> Iterator[Bench]:
    yield from make_bench(KEY)


@pytest.fixture
def open_bench() -> Iterator[Bench]:
    yield from make_bench(None)


def make_bench(key: bytes | None) -> Iterator[Bench]:
    bench = Bench(key)
    yield bench
    for client in (bench.gcs, bench.api):
        client.link.close()
        client.socket.close()


def test_all_links_take_and_give_only_what_is_signed(bench: Bench) -> None:
    for client in (bench.gcs, bench.api):
        assert bench.ask(client) == []
        client.use(KEY)
        assert bench.ask(client) == [0]
    assert len(bench.vehicle.autopilot.commands) == 2
    bench.endpoint.publish()
    heard = bench.api.take()
    assert heard
    assert all(message.get_signed() for message in heard)
    assert {message.get_link_id() for message in heard} == {1}
    assert bench.guard.refusals.totals == {Refusal.UNSIGNED: 2}


def test_bad_packets_change_nothing_and_the_next_valid_one_is_accepted(bench: Bench) -> None:
    bench.api.use(KEY)
    command = mavlink.MAVLink_command_long_message(1, 1, 400, 0, 1, *[0.0] * 6)
    good = bench.api.send(command)
    bench.handle()
    bench.api.take()
    forger = Client()
    forger.use(OTHER_KEY)
    forger.codec.signing.timestamp = 2**47
    ahead = Client()
    ahead.use(KEY)
    ahead.codec.signing.timestamp += 3600 * UNITS_PER_S
    unsigned = bytes(command.pack(mavlink.MAVLink(None, 255, 190)))
    bad = [good, unsigned, bytes(command.pack(forger.codec)), bytes(command.pack(ahead.codec))]
    for number, raw in enumerate(bad, 2):
        assert bench.ask(bench.api, raw) == []
        assert bench.ask(bench.api) == [0]
        assert len(bench.vehicle.autopilot.commands) == number
    assert bench.guard.refusals.totals == {
        Refusal.REPLAYED: 1,
        Refusal.UNSIGNED: 1,
        Refusal.BAD_SIGNATURE: 1,
        Refusal.FUTURE: 1,
    }
    for client in (forger, ahead):
        client.socket.close()


def test_an_unsigned_heartbeat_is_heard_but_makes_no_partner(bench: Bench) -> None:
    stranger = Client()
    stranger.link = bench.gcs.link
    stranger.send(HEARTBEAT)
    bench.handle()
    assert bench.gcs.link.gcs_heard
    assert bench.gcs.link.remote[1] == bench.gcs.port
    stranger.use(KEY)
    stranger.send(HEARTBEAT)
    bench.handle()
    assert bench.gcs.link.remote[1] == stranger.port
    stranger.socket.close()


def test_the_vehicles_own_packets_sent_back_to_it_change_nothing(bench: Bench) -> None:
    bench.endpoint.publish()
    echo = bench.gcs.socket.recv(4096)
    stranger = Client()
    stranger.socket.sendto(echo, ("127.0.0.1", bench.gcs.link.local_port))
    bench.handle()
    assert bench.gcs.link.remote[1] == bench.gcs.port
    assert set(bench.guard.refusals.totals) == {Refusal.OWN_NAME}
    stranger.socket.close()


def test_the_first_key_may_come_unsigned_and_later_ones_must_be_signed(open_bench: Bench) -> None:
    bench, gcs = open_bench, open_bench.gcs
    bench.hand_over(gcs, KEY)
    assert bench.guard.signing.is_on
    bench.hand_over(gcs, OTHER_KEY)  # unsigned
    gcs.use(KEY)
    assert bench.ask(gcs) == [0]
    bench.hand_over(gcs, OTHER_KEY)
    assert bench.ask(gcs) == []
    gcs.use(OTHER_KEY)
    assert bench.ask(gcs) == [0]
    bench.hand_over(gcs, NO_KEY)
    gcs.use(None)
    assert bench.ask(gcs) == [0]


def test_no_key_changes_while_armed(open_bench: Bench) -> None:
    open_bench.vehicle.autopilot.change(armed=True)
    open_bench.hand_over(open_bench.gcs, KEY)
    assert not open_bench.guard.signing.is_on
    assert open_bench.guard.refusals.totals == {Refusal.KEY_CHANGE: 1}


def test_a_key_is_never_forwarded(open_bench: Bench) -> None:
    stamp = 100 * EPOCH_S
    for target in ((0, 0), (1, 1), (7, 7)):
        message = mavlink.MAVLink_setup_signing_message(*target, list(KEY), stamp)
        open_bench.gcs.send(message)
    open_bench.handle()
    open_bench.api.codec.signing.secret_key = KEY
    assert "SETUP_SIGNING" not in [message.get_type() for message in open_bench.api.take()]


def test_what_is_refused_is_counted(open_bench: Bench) -> None:
    bench, gcs = open_bench, open_bench.gcs
    gcs.send(mavlink.MAVLink_command_long_message(1, 1, 512, 0, 9999, *[0.0] * 6))
    gcs.send(mavlink.MAVLink_param_set_message(1, 1, b"MPC_XY_VEL_MAX", 1e9, 9))
    gcs.send(mavlink.MAVLink_param_set_message(1, 1, b"NO_SUCH", 1.0, 9))
    gcs.send(mavlink.MAVLink_set_position_target_local_ned_message(0, 1, 1, 12, 1479, *[0.0] * 11))
    bench.handle()
    assert bench.guard.refusals.totals == {
        Refusal.COMMAND: 1,
        Refusal.PARAMETER: 2,
        Refusal.SETPOINT: 1,
    }
