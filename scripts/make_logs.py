#!/usr/bin/env python3
"""Make small logs of other vehicles and firmwares: python scripts/make_logs.py FOLDER.

They are built from the published message definitions; no position is real. A vehicle is armed and
away from its place between two times; what it sends, and how the log is written, tests may vary.
"""

import argparse
import math
import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from pymavlink.dialects.v20 import all as mavlink

PLANE, QUAD, ROVER, BOAT, SUB, GCS, COMPANION_TYPE = 1, 2, 10, 11, 12, 6, 18  # MAV_TYPE
GENERIC, ARDUPILOT, INVALID, PX4 = 0, 3, 8, 12  # MAV_AUTOPILOT
ARMED = 128
START_US = 1_700_000_000_000_000
SECOND = 1_000_000
Entry = tuple[int, bytes]  # time of the log, us, and a packet


@dataclass
class MadeSender:
    """One component that counts its packets."""

    system: int = 1
    component: int = 1
    version: int = 2

    def __post_init__(self) -> None:
        self.link = mavlink.MAVLink(None, self.system, self.component)

    def pack(self, message: Any) -> bytes:
        """Return the packet of a message."""
        raw: bytes = message.pack(self.link, force_mavlink1=self.version == 1)
        self.link.seq = (self.link.seq + 1) % 256
        return raw


def up_and_down(t: float) -> float:
    """Return the position down of a flight of 40 s at 10 m, m."""
    return -10 * max(0.0, min(1.0, (t - 10) / 8, (50 - t) / 8))


@dataclass(kw_only=True)
class MadeVehicle:
    """What a vehicle does and sends."""

    type: int = QUAD
    autopilot: int = ARDUPILOT
    mode: int = 0
    armed_s: tuple[float, float] = (10.0, 50.0)
    end_s: float = 60.0
    rate_hz: int = 10
    speed_m_s: float = 0.0
    boot_ms: int = 0
    turn_m: float = 0.0  # radius of its turns, 0: straight
    down: Callable[[float], float] = up_and_down

    def where(self, t: float) -> tuple[float, float, float, float]:
        """Return position and velocity, north and east, in m and m/s."""
        gone_m = self.speed_m_s * max(0.0, min(t, self.armed_s[1]) - self.armed_s[0])
        speed = self.speed_m_s if self.armed_s[0] <= t < self.armed_s[1] else 0.0
        if not self.turn_m:
            return gone_m, 0.0, speed, 0.0
        angle = gone_m / self.turn_m
        north, east = self.turn_m * math.sin(angle), self.turn_m * (1 - math.cos(angle))
        return north, east, speed * math.cos(angle), speed * math.sin(angle)

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
            north, east, v_north, v_east = self.where(t)
            yield t, mavlink.MAVLink_attitude_message(boot, 0.1 * math.sin(t), 0, 0, 0, 0, 0)
            place = (north, east, self.down(t), v_north, v_east, 0.0)
            yield t, mavlink.MAVLink_local_position_ned_message(boot, *place)


def entries(vehicle: MadeVehicle, sender: MadeSender | None = None) -> list[Entry]:
    """Return what a vehicle sends, logged as it comes."""
    by = sender or MadeSender()
    return [(START_US + round(t * 1e6), by.pack(m)) for t, m in vehicle.messages()]


def tlog(rows: list[Entry]) -> bytes:
    """Return entries, in order of time, as a tlog."""
    ordered = sorted(rows, key=lambda row: row[0])
    return b"".join(struct.pack(">Q", time_us % 2**64) + raw for time_us, raw in ordered)


def gps(n: int) -> Any:
    """Return what a GPS tells in its n-th second."""
    return mavlink.MAVLink_gps_raw_int_message(n * 10**6, 3, 0, 0, 0, 90, 120, 0, 0, 9 + n % 3)


def told(autopilot: int) -> list[Entry]:
    """Return what an autopilot tells of its sensors, outputs and estimator."""

    def make(n: int) -> list[Any]:
        ratios = (0.1, 0.2, 0.3, 0.4)
        estimator = (
            mavlink.MAVLink_ekf_status_report_message(831, *ratios, 0.0)
            if autopilot == ARDUPILOT
            else mavlink.MAVLink_estimator_status_message(n * 10**6, 831, *ratios, 0, 0, 0, 0)
        )
        channels = [1500 + n] * 8 + [65535] * 10
        return [
            gps(n),
            mavlink.MAVLink_vfr_hud_message(14.0 + n, 15.0, 0, 40, 30.0, 0.0),
            mavlink.MAVLink_rc_channels_message(n * 1000, 8, *channels, 200),
            mavlink.MAVLink_servo_output_raw_message(n, 0, 1500, 1400 + n, 1300, 1200, 0, 0, 0, 0),
            mavlink.MAVLink_vibration_message(n * 10**6, 5.0, 6.0, 7.0, 0, 0, 0),
            estimator,
        ]

    sender = MadeSender()
    return [
        (START_US + n * SECOND + part, sender.pack(message))
        for n in range(60)
        for part, message in enumerate(make(n))
    ]


# name: vehicle; what they fly, drive and send is made up
VEHICLES = {
    "copter": MadeVehicle(speed_m_s=3.0, turn_m=20.0, mode=3),
    "plane": MadeVehicle(type=PLANE, speed_m_s=18.0, turn_m=150.0, mode=10),
    "rover": MadeVehicle(type=ROVER, speed_m_s=2.0, turn_m=12.0, mode=10, down=lambda _t: 0.0),
}


def main() -> None:
    """Write one log a vehicle into a folder."""
    parser = argparse.ArgumentParser(description="Make small logs of other vehicles.")
    parser.add_argument("folder", type=Path)
    folder = parser.parse_args().folder
    folder.mkdir(parents=True, exist_ok=True)
    for name, vehicle in VEHICLES.items():
        path = folder / f"{name}.tlog"
        path.write_bytes(tlog(entries(vehicle) + told(vehicle.autopilot)))
        print(f"wrote {path}")


if __name__ == "__main__":
    main()
