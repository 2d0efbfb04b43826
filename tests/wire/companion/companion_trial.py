"""One flight of the companion, with a pilot that only flies straight on, and the small vehicle."""

import contextlib
import socket
from collections.abc import Iterator
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
from pymavlink import mavutil

from flightstack.companion.console import Console
from flightstack.companion.flight import fly
from flightstack.companion.opening.steps import FlightPlan
from flightstack.companion.piloting.in_process import InProcessPilot
from flightstack.companion.summary import FlightSummary
from flightstack.mavlink.endpoint import parse_endpoint
from flightstack.mavlink.motion import MotionHistory
from flightstack.records import ALL_MEMBERS, Decision, Image
from tests.wire.fake_vehicle import FakeVehicle, Script

FORWARD_M_S = 2.0


class ForwardPilot:
    """Flies straight on, whatever it sees."""

    def __init__(self, command: tuple[float, float, float, float] = (FORWARD_M_S, 0, 0, 0)) -> None:
        self.command = np.array(command, float)
        self.images: list[Image] = []

    def decide(self, image: Image) -> Decision:
        self.images.append(image)
        return Decision(
            command=self.command,
            aleatoric_std=np.full(4, 0.3),
            epistemic_std=np.full(4, 0.2),
            perceptual_std=np.full(4, 0.1),
            score=np.zeros((5, 4)),
            member=np.full(4, ALL_MEMBERS),
            modes=np.ones(4, int),
            member_mean=np.tile(self.command, (5, 1)),
        )


def guarded(_motion: MotionHistory) -> InProcessPilot:
    return InProcessPilot(ForwardPilot())


def free_port() -> int:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
        return port


class Trial:
    """One flight of the companion with the fake vehicle, and what either side saw."""

    def __init__(self, tmp_path: Path, script: Script, **plan: Any) -> None:
        port = free_port()
        self.pilot = ForwardPilot()
        self.output = StringIO()
        self.vehicle = FakeVehicle(port, script)
        defaults: dict[str, Any] = {"timeout_s": 10.0, "log": tmp_path / "flight.tlog"}
        self.plan = FlightPlan(
            endpoint=parse_endpoint(f"udpin:127.0.0.1:{port}"), **(defaults | plan)
        )

    def fly(self) -> FlightSummary:
        with self.vehicle:
            return self.fly_alone()

    def fly_alone(self) -> FlightSummary:
        """Fly whatever is there by itself."""
        return fly(
            self.plan,
            lambda _motion: InProcessPilot(self.pilot),
            Console(verbosity=1, stream=self.output),
        )


def read_tlog(path: Path) -> Iterator[Any]:
    log = mavutil.mavlink_connection(str(path), dialect="common")
    with contextlib.closing(log):
        while (message := log.recv_match()) is not None:
            yield message
