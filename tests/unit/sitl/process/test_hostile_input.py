"""A flying vehicle under hostile datagrams: it keeps its mode, its place and its sockets."""

import itertools
from collections.abc import Iterator

import pytest

from scripts.bench.attacks.hostile_datagrams import Generator
from sitl.flown_vehicle import SimulationConfig
from sitl.mavlink.endpoint import Endpoint
from sitl.mavlink.links.link import Guard
from sitl.mavlink.servers.files.storage import Storage
from sitl.mavlink.wire.dialect import mavlink
from sitl.mavlink.wire.packets import pack, wrap
from sitl.mavlink.wire.signing import Signing
from sitl.records.modes import Mode
from sitl.simulation import Simulation
from tests.unit.sitl.mavlink.bench import FACTS, Peer, handle, link_to

KEY = bytes(range(1, 33))
TICKS = 500
DATAGRAMS_A_TICK = 12
START_NED = (0.0, -2.0, -3.0)


class Bench:
    """A simulation with both links, an honest pilot on one and an attacker on both."""

    def __init__(self, storage: Storage, *, signed: bool) -> None:
        self.simulation = Simulation(SimulationConfig(perfect_estimate=True))
        self.simulation.start_airborne(START_NED, 0.0)
        self.guard = Guard(signing=Signing(KEY if signed else None))
        self.pilot_signing = Signing(KEY if signed else None)
        self.peer = Peer()  # of both
        self.links = [link_to(self.peer, index, self.guard) for index in range(2)]
        self.endpoint = Endpoint(
            self.simulation,
            self.links,
            system=1,
            camera=FACTS,
            guard=self.guard,
            storage=storage,
        )
        self.datagrams = iter(Generator(0, orders=signed))

    def close(self) -> None:
        self.endpoint.close()
        for link in self.links:
            link.close()
        self.peer.socket.close()
        self.simulation.close()

    def attack(self) -> None:
        for number, datagram in enumerate(itertools.islice(self.datagrams, DATAGRAMS_A_TICK)):
            link = self.links[number % 2]
            self.peer.socket.sendto(datagram, ("127.0.0.1", link.local_port))
        handle(self.endpoint, self.links)

    def steer(self) -> None:
        message = mavlink.MAVLink_set_position_target_local_ned_message(
            self.simulation.time_us // 1000, 1, 1, 1, 0x5F8, *START_NED, *[0.0] * 8
        )
        is_signed = self.pilot_signing.is_on
        raw = wrap(pack(message), sequence=0, system=1, component=191, is_signed=is_signed)
        raw += self.pilot_signing.signature(raw, 9) if is_signed else b""
        self.peer.socket.sendto(raw, ("127.0.0.1", self.links[1].local_port))
        handle(self.endpoint, self.links)


@pytest.fixture(params=[False, True], ids=["without a key", "with a key"])
def bench(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Bench]:
    storage = Storage(tmp_path_factory.mktemp("vehicle"))
    bench = Bench(storage, signed=request.param)
    yield bench
    bench.close()
    storage.close()


def test_a_vehicle_under_attack_flies_its_setpoints(bench: Bench) -> None:
    simulation = bench.simulation
    for _ in range(TICKS):
        bench.attack()
        bench.steer()  # last, as in lockstep: what it says is flown
        simulation.step()
        bench.endpoint.publish()
        assert simulation.autopilot.status.mode is Mode.OFFBOARD
    away = [abs(a - b) for a, b in zip(simulation.state.position_ned, START_NED, strict=True)]
    assert max(away) < 0.3
    assert simulation.autopilot.status.armed
    assert bench.guard.refusals.totals.total() > TICKS
    assert bench.guard.signing.is_on == bench.pilot_signing.is_on
