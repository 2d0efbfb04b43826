"""Four vehicles at once on their own ports, each flown elsewhere by a pymavlink client."""

import contextlib
import math
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from pymavlink import mavutil
from pymavlink.dialects.v20 import common as mavlink

from flightstack.launch.instances import API_PORT, free_instance
from tests.flight.processes import process

pytestmark = pytest.mark.flight
VEHICLES = 4
SPEED = 2
BY_POSITION = 0xDF8  # type_mask: x, y, z only
LOSS_S = 10.0  # COM_OF_LOSS_T: a slow host keeps the streams alive
SETPOINT_S = 0.05
PATIENCE_S = 90.0  # wall time for a flight of some 20 s of vehicle time


@dataclass(slots=True)
class Client:
    """One person's program: it hears one port, and flies what it hears there to its goal."""

    instance: int
    goal_ned: tuple[float, float, float]
    systems: set[int] = field(default_factory=set)  # whom it has heard
    nearest_m: float = math.inf
    highest_m: float = 0.0
    end_ned: tuple[float, float, float] = (0.0, 0.0, 0.0)
    link: Any = None
    _sent_s: float = 0.0

    def fly(self) -> None:
        """Take off in OFFBOARD, reach the goal, land."""
        self.link = mavutil.mavlink_connection(f"udpin:127.0.0.1:{API_PORT + self.instance}")
        with contextlib.closing(self.link):
            self._wait(lambda m: _is_beat(m) and m.system_status == mavlink.MAV_STATE_STANDBY)
            self.link.target_system, self.link.target_component = self.instance + 1, 1
            self.link.param_set_send("COM_OF_LOSS_T", LOSS_S, mavlink.MAV_PARAM_TYPE_REAL32)
            self._steer()
            self._command(mavlink.MAV_CMD_DO_SET_MODE, 1.0, 6.0)
            self._command(mavlink.MAV_CMD_COMPONENT_ARM_DISARM, 1.0)
            self._wait(lambda _: self.nearest_m < 0.5, steers=True)
            self._command(mavlink.MAV_CMD_NAV_LAND)
            self._wait(
                lambda m: _is_beat(m) and not m.base_mode & mavlink.MAV_MODE_FLAG_SAFETY_ARMED
            )

    def _wait(self, condition: Any, *, steers: bool = False) -> None:
        deadline_s = time.monotonic() + PATIENCE_S
        while time.monotonic() < deadline_s:
            message = self.link.recv_match(blocking=True, timeout=SETPOINT_S)
            if steers and time.monotonic() - self._sent_s > SETPOINT_S:
                self._steer()
            if message is None or message.get_srcComponent() != 1:
                continue
            self.systems.add(message.get_srcSystem())
            if message.get_type() == "LOCAL_POSITION_NED":
                self.end_ned = (message.x, message.y, message.z)
                self.nearest_m = min(self.nearest_m, math.dist(self.end_ned, self.goal_ned))
                self.highest_m = max(self.highest_m, -message.z)
            if condition(message):
                return
        raise AssertionError(f"vehicle {self.instance}: nothing came of it, at {self.end_ned}")

    def _steer(self) -> None:
        self._sent_s = time.monotonic()
        target, rest = (self.link.target_system, 1), (0.0,) * 8
        self.link.mav.set_position_target_local_ned_send(
            0, *target, mavlink.MAV_FRAME_LOCAL_NED, BY_POSITION, *self.goal_ned, *rest
        )

    def _command(self, number: int, *params: float) -> None:
        values = [*params, *[math.nan] * (7 - len(params))]
        self.link.mav.command_long_send(self.link.target_system, 1, number, 0, *values)


def _is_beat(message: Any) -> bool:
    return bool(message.get_type() == "HEARTBEAT")


@pytest.fixture
def clients(tmp_path: Path) -> Iterator[list[Client]]:
    """Four vehicles up, and a client for each."""
    with contextlib.ExitStack() as stack:
        made = []
        for number in range(VEHICLES):
            instance = stack.enter_context(free_instance())
            options = (f"--instance={instance}", f"--speed-factor={SPEED}", f"--seed={number}")
            log = tmp_path / f"vehicle-{instance}.txt"
            stack.enter_context(process("sitl", *options, log=log))
            angle = number * math.tau / VEHICLES
            goal = (2.0 * math.cos(angle), 2.0 * math.sin(angle), -2.0 - 0.5 * number)
            made.append(Client(instance, goal))
        yield made


def test_each_flies_where_its_own_client_sends_it(clients: list[Client]) -> None:
    assert len({client.instance for client in clients}) == VEHICLES
    with ThreadPoolExecutor(VEHICLES) as pool:
        for flight in [pool.submit(client.fly) for client in clients]:
            flight.result()
    for client in clients:
        assert client.systems == {client.instance + 1}
        assert client.nearest_m < 0.5
        assert client.highest_m < -client.goal_ned[2] + 0.8
        assert math.dist(client.end_ned[:2], client.goal_ned[:2]) < 1.5
        assert abs(client.end_ned[2]) < 0.8  # down again, as far as it knows
