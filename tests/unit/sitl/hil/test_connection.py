import socket
from contextlib import suppress

import numpy as np
import pytest

from sitl.errors import LinkError
from sitl.hil.connection import MAX_STRANGERS, Px4Connection
from tests.wire.px4_stand_in import OPENING, RECORDED, Px4StandIn

HOSTILE_BYTES = 1_000_000


def connect(connection: Px4Connection) -> Px4StandIn:
    px4 = Px4StandIn(connection.address[1])
    while not connection.is_connected:
        connection.serve(1.0)
    return px4


def test_a_px4_is_known_by_its_first_packet(connection: Px4Connection) -> None:
    with Px4StandIn(connection.address[1], opening=False) as px4:
        connection.serve(1.0)
        assert not connection.is_connected  # it may be anybody
        px4.socket.sendall(OPENING[0][:20])
        connection.serve(1.0)
        assert not connection.is_connected
        px4.socket.sendall(OPENING[0][20:])
        connection.serve(1.0)
        assert connection.is_connected
        px4.socket.sendall(RECORDED[7])
        connection.serve(1.0)
        motors = connection.take_motors()
        assert motors is not None
        assert motors.armed
        assert connection.take_motors() is None  # each is handed over once


def test_a_second_client_is_closed_and_the_first_stays(connection: Px4Connection) -> None:
    with connect(connection) as px4, Px4StandIn(connection.address[1]) as second:
        connection.serve(1.0)
        assert second.is_refused
        px4.answer(4000, 0.5)
        connection.serve(1.0)
        assert connection.take_motors() is not None


def test_nonsense_is_closed_and_a_px4_is_heard_afterwards(connection: Px4Connection) -> None:
    chance = np.random.default_rng(1)
    left = HOSTILE_BYTES
    while left > 0:
        with socket.create_connection(connection.address[:2]) as hostile, suppress(OSError):
            connection.serve(1.0)
            piece = chance.bytes(65536)
            left -= len(piece)
            hostile.sendall(piece)
            connection.serve(1.0)
    assert connection.refused >= HOSTILE_BYTES // 65536
    assert not connection.is_connected
    connect(connection).socket.close()


def test_who_says_nothing_keeps_nobody_out(connection: Px4Connection) -> None:
    silent = [socket.create_connection(connection.address) for _ in range(MAX_STRANGERS - 1)]
    for _ in silent:
        connection.serve(1.0)
    connect(connection).socket.close()
    for stranger in silent:
        assert stranger.recv(1) == b""
        stranger.close()


def test_nonsense_within_the_stream_is_skipped(connection: Px4Connection) -> None:
    with connect(connection) as px4:
        px4.socket.sendall(
            np.random.default_rng(2).bytes(3000).replace(b"\xfd", b"").replace(b"\xfe", b"")
        )
        px4.answer(8000, 0.25)
        motors = None
        while motors is None:
            connection.serve(1.0)
            motors = connection.take_motors()
        assert motors.thrusts == (0.25,) * 4


def test_another_px4_comes_after_the_first(connection: Px4Connection) -> None:
    connect(connection).socket.close()
    connection.serve(1.0)
    assert not connection.is_connected
    connect(connection).socket.close()
    assert connection.connections == 2


def test_a_port_that_is_taken_is_named(connection: Px4Connection) -> None:
    with pytest.raises(LinkError, match=f"{connection.address[1]}.*is in use"):
        Px4Connection(connection.address)
