"""Make small logs of other vehicles and firmwares from the published message definitions.

No position is real. A vehicle is armed and away from its place between two times; what it sends,
how often, and how the log is written, is for each test to say.
"""

import math
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

from pymavlink.dialects.v20 import all as mavlink

from flightstack.logs import read_bytes
from flightstack.logs.checks import run_checks
from flightstack.logs.facts.summary import summarise
from flightstack.logs.facts.values import Facts
from flightstack.logs.flight.flight import Flight
from tests.unit.flightstack.logs.made_logs import START_US

PLANE, QUAD, ROVER, BOAT, SUB, GCS, COMPANION_TYPE = 1, 2, 10, 11, 12, 6, 18  # MAV_TYPE
GENERIC, ARDUPILOT, INVALID, PX4 = 0, 3, 8, 12  # MAV_AUTOPILOT
ARMED = 128
SECOND = 1_000_000
Entry = tuple[int, bytes]  # time of the log, us, and a packet


@dataclass
class Sender:
    """One component that counts its packets."""

    system: int = 1
    component: int = 1
    version: int = 2

    def __post_init__(self) -> None:
        self.link = mavlink.MAVLink(None, self.system, self.component)

    def pack(self, message: Any) -> bytes:
        raw: bytes = message.pack(self.link, force_mavlink1=self.version == 1)
        self.link.seq = (self.link.seq + 1) % 256
        return raw


@dataclass(kw_only=True)
class Vehicle:
    """What a vehicle does and sends."""

    type: int = QUAD
    autopilot: int = ARDUPILOT
    mode: int = 0
    armed_s: tuple[float, float] = (10.0, 50.0)
    end_s: float = 60.0
    rate_hz: int = 10
    speed_m_s: float = 0.0
    boot_ms: int = 0
    down: Callable[[float], float] = lambda t: -10 * max(0.0, min(1.0, (t - 10) / 8, (50 - t) / 8))

    def messages(self) -> Iterator[tuple[float, Any]]:
        """Yield time in seconds and message, in order."""
        for tick in range(int(self.end_s * self.rate_hz)):
            t = tick / self.rate_hz
            boot = self.boot_ms + round(t * 1000)
            armed = self.armed_s[0] <= t < self.armed_s[1]
            if tick % self.rate_hz == 0:
                base = 1 | (ARMED if armed else 0)
                yield (
                    t,
                    mavlink.MAVLink_heartbeat_message(
                        self.type, self.autopilot, base, self.mode, 4 if armed else 3, 3
                    ),
                )
                yield (
                    t,
                    mavlink.MAVLink_sys_status_message(
                        0, 0, 0, 100, 12600, -1, 90, 0, 0, 0, 0, 0, 0
                    ),
                )
            speed = self.speed_m_s if armed else 0.0
            yield t, mavlink.MAVLink_attitude_message(boot, 0.1 * math.sin(t), 0, 0, 0, 0, 0)
            yield (
                t,
                mavlink.MAVLink_local_position_ned_message(
                    boot, speed * max(0.0, t - self.armed_s[0]), 0, self.down(t), speed, 0, 0
                ),
            )


def entries(vehicle: Vehicle, sender: Sender | None = None) -> list[Entry]:
    """Return what a vehicle sends, logged as it comes."""
    by = sender or Sender()
    return [(START_US + round(t * 1e6), by.pack(m)) for t, m in vehicle.messages()]


def tlog(rows: list[Entry]) -> bytes:
    """Return entries, in order of time, as a tlog."""
    ordered = sorted(rows, key=lambda row: row[0])
    return b"".join(struct.pack(">Q", time_us % 2**64) + raw for time_us, raw in ordered)


def facts_of(rows: list[Entry], system: int | None = None) -> Facts:
    flight = Flight(read_bytes(tlog(rows)), system)
    return summarise(flight, run_checks(flight))


def level(facts: Facts, name: str) -> str:
    return next(str(each["level"]) for each in facts["checks"] if each["name"] == name)


def every(
    step_s: float, sender: Sender, make: Callable[[int], Any], end_s: float = 60
) -> list[Entry]:
    count = int(end_s / step_s)
    return [(START_US + round(n * step_s * SECOND) + 3, sender.pack(make(n))) for n in range(count)]


def beat(kind: int, autopilot: int, mode: int = 0) -> Any:
    return mavlink.MAVLink_heartbeat_message(kind, autopilot, 0, mode, 4, 3)
