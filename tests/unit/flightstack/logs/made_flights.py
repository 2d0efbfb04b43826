"""Make the log of a whole flight: take-off, some seconds of OFFBOARD through gates, landing.

The vehicle follows its body velocity setpoint with a first-order lag; decisions stand beside the
setpoints as the companion sends them, and the referee's gates and words as it sends its.
"""

import math
import struct
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from pymavlink.dialects.v20 import all as mavlink

from tests.unit.flightstack.logs.made_logs import START_US

BOOT_US = 3_000_000
TICK_US = 20_000
LAG_S = 0.3
PX4_OFFBOARD, PX4_LOITER, PX4_TAKEOFF, PX4_LAND = 0x00060000, 0x03040000, 0x02040000, 0x06040000
VEHICLE, REFEREE, CAMERA, COMPANION = 1, 25, 100, 191
TAKE_OFF_S, OFFBOARD_S = 2.0, 8.0
GATES = 8
RADIUS_M = 8.0


@dataclass
class Recorder:
    """Collects records; each component counts its own sequence."""

    parts: list[bytes] = field(default_factory=list)
    senders: dict[int, Any] = field(default_factory=dict)
    now_us: int = 0
    skip: int = 0  # leave out every n-th setpoint

    def add(self, component: int, message: Any, *, delay_us: int = 0) -> None:
        sender = self.senders.setdefault(component, mavlink.MAVLink(None, 1, component))
        raw = message.pack(sender)
        sender.seq = (sender.seq + 1) % 256
        self.parts.append(struct.pack(">Q", (START_US + self.now_us + delay_us) & ~3) + raw)


def gate_item(index: int) -> Any:
    angle = 2 * math.pi * index / GATES
    north, east = RADIUS_M * math.sin(angle), RADIUS_M * (1 - math.cos(angle))
    heading = math.degrees(angle) % 360
    return mavlink.MAVLink_mission_item_int_message(
        1, COMPANION, index, 1, 16, 0, 1, 0, 0.6, 0, heading, int(north * 1e4), int(east * 1e4), -3
    )


def beat(mode: int, *, armed: bool) -> Any:
    return mavlink.MAVLink_heartbeat_message(
        2, 12, 1 | (128 if armed else 0), mode, 4 if armed else 3, 3
    )


def decision(stamp_us: int, command: list[float], rng: np.random.Generator, t: float) -> Any:
    alea = [0.10 + 0.02 * math.sin(t)] * 3 + [0.05]
    epis = [0.05 + 0.3 * max(0.0, math.sin(t / 2)) ** 4] * 3 + [0.02]
    perc = [0.04] * 4
    score = rng.normal(0.1, 0.01, 4).tolist()
    member = [float(int(t) % 5)] * 4
    modes = [1.0 + (math.sin(t / 2) > 0.9)] * 4
    data = [*alea, *epis, *perc, *score, *member, *modes, *command]
    return mavlink.MAVLink_debug_float_array_message(
        stamp_us, b"decision", 0, [*data, *([0.0] * (58 - len(data)))]
    )


def members(stamp_us: int, command: list[float], rng: np.random.Generator) -> Any:
    means = [value + rng.normal(0, 0.1) for _ in range(5) for value in command]
    return mavlink.MAVLink_debug_float_array_message(
        stamp_us, b"members", 1, [*means, *([0.0] * (58 - len(means)))]
    )


@dataclass
class Body:
    """Where the vehicle is, following its setpoint."""

    north: float = 0.0
    east: float = 0.0
    down: float = 0.0
    yaw: float = 0.0
    velocity: list[float] = field(default_factory=lambda: [0.0] * 4)  # body, yaw rate

    def follow(self, setpoint: list[float], dt: float) -> None:
        gain = dt / LAG_S
        self.velocity = [v + gain * (s - v) for v, s in zip(self.velocity, setpoint, strict=True)]
        north, east = self.ned()[:2]
        self.north += north * dt
        self.east += east * dt
        self.down += self.velocity[2] * dt
        self.yaw += self.velocity[3] * dt

    def ned(self) -> tuple[float, float, float]:
        c, s = math.cos(self.yaw), math.sin(self.yaw)
        vx, vy, vz, _ = self.velocity
        return c * vx - s * vy, s * vx + c * vy, vz


def _telemetry(log: Recorder, body: Body, boot_ms: int) -> None:
    wrapped = math.atan2(math.sin(body.yaw), math.cos(body.yaw))
    log.add(
        VEHICLE,
        mavlink.MAVLink_attitude_message(boot_ms, 0.01, -0.05, wrapped, 0, 0, body.velocity[3]),
    )
    log.add(
        VEHICLE,
        mavlink.MAVLink_local_position_ned_message(
            boot_ms, body.north, body.east, body.down, *body.ned()
        ),
    )


def _slow(log: Recorder, second: int, mode: int, *, armed: bool, landed: int) -> None:
    log.add(VEHICLE, beat(mode, armed=armed))
    log.add(VEHICLE, mavlink.MAVLink_extended_sys_state_message(0, landed))
    log.add(
        VEHICLE,
        mavlink.MAVLink_sys_status_message(
            0, 0, 0, 100, 16200 - 10 * second, -1, 100 - second, 0, 0, 0, 0, 0, 0
        ),
    )
    log.add(COMPANION, mavlink.MAVLink_heartbeat_message(18, 8, 0, 0, 4, 3))


def _frame(
    log: Recorder, body: Body, t: float, rng: np.random.Generator, number: int
) -> list[float]:
    stamp_us = BOOT_US + log.now_us
    command = [1.5 + 0.5 * math.sin(1.3 * t), 0.3 * math.sin(t), 0.1 * math.sin(2 * t), 0.19]
    log.add(CAMERA, mavlink.MAVLink_camera_trigger_message(stamp_us, number))
    if log.skip and number % log.skip == 0:
        return command
    setpoint = mavlink.MAVLink_set_position_target_local_ned_message(
        stamp_us // 1000, 1, 1, 8, 0x5C7, 0, 0, 0, *command[:3], 0, 0, 0, 0, command[3]
    )
    log.add(COMPANION, setpoint, delay_us=4000)
    log.add(COMPANION, decision(stamp_us, command, rng, t), delay_us=4100)
    log.add(COMPANION, members(stamp_us, command, rng), delay_us=4200)
    del body
    return command


def _say(log: Recorder, component: int, text: bytes, severity: int = 6) -> None:
    log.add(component, mavlink.MAVLink_statustext_message(severity, text))


def _phase(t: float, end_s: float) -> tuple[int, bool, int]:
    """Return mode, armed, landed state."""
    if t < TAKE_OFF_S:
        return PX4_LOITER, False, 1
    if t < OFFBOARD_S:
        return PX4_TAKEOFF, True, 3
    if t < end_s:
        return PX4_OFFBOARD, True, 2
    return (PX4_LAND, True, 4) if t < end_s + 5 else (PX4_LAND, False, 1)


def make_flight(flight_s: float = 20.0, *, misses: bool = True, skip: int = 0) -> bytes:
    """Return the tlog of a flight with this long in OFFBOARD; it ends with a missed gate."""
    rng = np.random.default_rng(4)
    log = Recorder(skip=skip)
    body = Body()
    end_s = OFFBOARD_S + flight_s
    passed = 0
    setpoint = [0.0] * 4
    for index in range(GATES):
        log.add(REFEREE, gate_item(index))
    for tick in range(int((end_s + 8) * 1e6 / TICK_US)):
        log.now_us = tick * TICK_US
        t = log.now_us * 1e-6
        mode, armed, landed = _phase(t, end_s)
        if tick % 50 == 0:
            _slow(log, tick // 50, mode, armed=armed, landed=landed)
        climbing = [0.0, 0.0, -0.5 if mode == PX4_TAKEOFF else 0.6, 0.0]
        if mode == PX4_OFFBOARD:
            if tick % 5 in (0, 2):  # 20 Hz in ticks of 20 ms: 40 and 60 ms apart
                setpoint = _frame(log, body, t, rng, tick)
            body.follow(setpoint, TICK_US * 1e-6)
            if tick % 200 == 150:
                log.add(REFEREE, mavlink.MAVLink_mission_item_reached_message(passed))
                passed += 1
                _say(log, REFEREE, b"Passed gate %d of 32" % passed)
        elif armed:
            body.follow(climbing, TICK_US * 1e-6)
        else:
            body.velocity = [0.0] * 4
        _telemetry(log, body, (BOOT_US + log.now_us) // 1000)
        if tick == int(TAKE_OFF_S * 50):
            _say(log, VEHICLE, b"Armed by external command\t")
        if misses and tick == int(end_s * 50) - 5:
            _say(log, REFEREE, b"Missed gate %d: passed outside" % (passed + 1), 4)
    return b"".join(log.parts)
