"""A flight loop whose vehicle, camera and clock are the test's: nothing waits, nothing is sent."""

from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pymavlink.dialects.v20 import common

from flightstack.arrays import Rgb
from flightstack.camera.mailbox import Arrival
from flightstack.companion import loop as loop_module
from flightstack.companion.console import Console
from flightstack.companion.loop import FlightLoop
from flightstack.companion.mission.records import MissionPhase, MissionStatus
from flightstack.companion.piloting.in_process import InProcessPilot
from flightstack.companion.reporter import Reporter
from flightstack.companion.vehicle_session import VehicleSession
from flightstack.errors import FlightstackError
from flightstack.px4_modes import Px4Mode
from flightstack.records import ALL_MEMBERS, Decision, Image
from tests.unit.flightstack.mavlink.made_link import MadeLink, heartbeat

SIZE = (8, 8, 3)
ARMED = 128 | 29
FORWARD_M_S = 2.0


class MadeCamera:
    """Hands over what the test has put into it."""

    def __init__(self) -> None:
        self.announced_hz: float | None = None
        self.fault: FlightstackError | None = None
        self.arrival: Arrival | None = None
        self.restarts = 0

    def fileno(self) -> int:
        raise NotImplementedError

    def take(self) -> Arrival | None:
        arrival, self.arrival = self.arrival, None
        return arrival

    def restart(self) -> None:
        self.restarts += 1


class ForwardPilot:
    """Flies straight on, and counts what it has seen."""

    def __init__(self) -> None:
        self.seen = 0

    def decide(self, image: Image) -> Decision:  # noqa: ARG002  (flies blind)
        self.seen += 1
        command = np.array([FORWARD_M_S, 0.0, 0.0, 0.0])
        spread = np.full(4, 0.1)
        return Decision(
            command=command,
            aleatoric_std=spread,
            epistemic_std=spread,
            perceptual_std=spread,
            score=np.zeros((1, 4)),
            member=np.full(4, ALL_MEMBERS),
            modes=np.ones(4, np.int64),
            member_mean=command[np.newaxis],
        )


RESTARTS_MS = 600  # of wall time, where a vehicle's clock goes back


class MadeFlight:
    """One loop in FLYING; the vehicle says at each turn that it is in OFFBOARD."""

    def __init__(
        self,
        folder: Path,
        monkeypatch: pytest.MonkeyPatch,
        *,
        announced_hz: float | None = None,
    ) -> None:
        self.made = MadeLink(folder)
        self.camera, self.pilot = MadeCamera(), ForwardPilot()
        self.camera.announced_hz = announced_hz
        self.speed_m_s: float | None = None
        self.said = StringIO()
        self.picture: Rgb | None = None
        self._pictures, self._rng = 0, np.random.default_rng(0)
        self.session = VehicleSession(self.made.link, 3.0)
        self._say(0)
        self.session.receive()
        self.loop = FlightLoop(
            self.session,
            self.camera,
            InProcessPilot(self.pilot),
            Reporter(Console(verbosity=-2, stream=self.said)),
            mission=MissionStatus(phase=MissionPhase.FLYING, offboard_us=0, entered_us=0),
        )
        monkeypatch.setattr(loop_module, "wait_for_any", self._wait)

    def phase(self) -> MissionPhase:
        return self.loop.status.phase

    def turn(self, after_ms: int, *, image: bool = True) -> list[Any]:
        """Let time pass on both clocks, and the loop turn once; return what it has sent."""
        now_ms = self.made.clock.stamp_us // 1000 + after_ms
        self.made.wall.now_s += (after_ms if after_ms >= 0 else RESTARTS_MS) / 1000
        self._say(now_ms)
        if image:
            self.show(now_ms * 1000)
        before = len(self.made.transport.sent)
        self.loop._turn()
        return self.sent()[before:]

    def show(self, stamp_us: int) -> None:
        """Have the camera give a picture like no other, unless the test has chosen one."""
        self._pictures += 1
        rgb = self.picture
        if rgb is None:
            rgb = self._rng.integers(0, 256, SIZE, np.uint8)
        image = Image(stamp_us=stamp_us, sequence=self._pictures, rgb=rgb)
        self.camera.arrival = Arrival(image, self.made.wall.now_s)

    def silence(self, for_s: float) -> None:
        """Let the wall's time pass without a word, and the loop turn once."""
        self.made.wall.now_s += for_s
        self.loop._turn()

    def sent(self) -> list[Any]:
        """Every message that went out; those of one datagram as one list."""
        parser = common.MAVLink(None)
        datagrams = [parser.parse_buffer(packets) for packets, _ in self.made.transport.sent]
        return [datagram or [] for datagram in datagrams]

    def _say(self, now_ms: int) -> None:
        self.made.say(common.MAVLink_attitude_message(now_ms, 0, 0, 0, 0, 0, 0))
        if self.speed_m_s is not None:
            position = (now_ms, 0, 0, 0, self.speed_m_s, 0, 0)
            self.made.say(common.MAVLink_local_position_ned_message(*position))
        self.made.say(heartbeat(mode=Px4Mode.OFFBOARD, base_mode=ARMED, status=4))

    def _wait(self, timeout_s: float, *_: object) -> bool:  # noqa: ARG002  (nobody waits)
        return False


def forward_m_s(sent: list[list[Any]]) -> list[float]:
    """The forward velocity of each setpoint."""
    kind = "SET_POSITION_TARGET_LOCAL_NED"
    return [m.vx for datagram in sent for m in datagram if m.get_type() == kind]
