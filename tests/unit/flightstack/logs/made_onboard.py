"""Write vehicle's own logs of one made flight: PX4's ULog and ArduPilot's DataFlash.

Both are written byte by byte from the formats' published definitions; the field names are those of
PX4 v1.17 and ArduPilot 4.5. The flight: armed at 2 s, aloft from 4 s to 34 s, swaying.
"""

import math
import struct
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
BOOT_UTC_US = 1_700_000_000_000_000
STEP_US = 50_000
END_S = 38.0
ARMED_S, LIFTED_S, LANDED_S, DISARMED_S = 2.0, 4.0, 34.0, 36.0


class Sway(NamedTuple):
    """Where the vehicle is at some time."""

    roll: float
    pitch: float
    yaw: float
    position: tuple[float, float, float]
    velocity: tuple[float, float, float]


def sway(t: float) -> Sway:
    """Return the motion at t seconds after boot: no part of it repeats another."""
    aloft = LIFTED_S <= t < LANDED_S
    u = t - LIFTED_S if aloft else 0.0
    roll = 0.2 * math.sin(0.9 * u) + 0.1 * math.sin(0.023 * u * u)
    pitch = 0.15 * math.sin(1.3 * u) * math.sin(0.11 * u)
    north, east = 3 * math.sin(0.4 * u), 2 * (1 - math.cos(0.5 * u))
    vn, ve = (1.2 * math.cos(0.4 * u), math.sin(0.5 * u)) if aloft else (0.0, 0.0)
    height = 5.0 * min(u / 3, 1.0, max(0.0, (LANDED_S - t) / 3)) if aloft else 0.0
    return Sway(roll, pitch, 0.3 * math.sin(0.2 * u), (north, east, -height), (vn, ve, 0.0))


def times_us(step_us: int = STEP_US, end_s: float = END_S) -> range:
    return range(500_000, int(end_s * 1e6), step_us)


def quaternion(roll: float, pitch: float, yaw: float) -> tuple[float, float, float, float]:
    (cr, sr), (cp, sp), (cy, sy) = [(math.cos(a / 2), math.sin(a / 2)) for a in (roll, pitch, yaw)]
    return (
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    )


ULOG_CODES = {"uint64_t": "Q", "float": "f", "uint8_t": "B", "bool": "?", "uint32_t": "I",
              "double": "d", "char": "c"}  # fmt: skip


class UlogTopic(NamedTuple):
    """A topic: its format as ULog writes it, "uint64_t timestamp;float[3] xyz;", and records."""

    name: str
    format: str
    rows: Sequence[Sequence[Any]]
    instance: int = 0

    @property
    def struct(self) -> str:
        kinds = [field.split(" ")[0] for field in self.format.split(";") if field]
        codes = []
        for kind in kinds:
            base, _, length = kind.rstrip("]").partition("[")
            codes.append(f"{length or 1}{'s' if base == 'char' else ULOG_CODES[base]}")
        return "<" + "".join(codes)


def _ulog_message(kind: str, body: bytes) -> bytes:
    return struct.pack("<HB", len(body), ord(kind)) + body


def _key_value(kind: str, name: str, value: bytes) -> bytes:
    key = f"{kind} {name}".encode()
    return bytes([len(key)]) + key + value


def parameter(name: str, value: float) -> bytes:
    is_integer = isinstance(value, int)
    raw = struct.pack("<i" if is_integer else "<f", value)
    return _ulog_message("P", _key_value("int32_t" if is_integer else "float", name, raw))


def ulog(
    topics: Iterable[UlogTopic],
    *,
    texts: Sequence[tuple[int, str, str]] = (),
    dropouts: Sequence[int] = (),
    parameters: dict[str, float] | None = None,
) -> bytes:
    """Return a ULog: topics, texts (boot time us, level 0 to 7, text), dropouts (ms), parameters.

    Dropouts stand behind the first record that has a time.
    """
    topics = list(topics)
    head = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 100_000)
    parts = [head, _ulog_message("B", bytes(40))]
    forms = dict.fromkeys((topic.name, topic.format) for topic in topics)
    parts += [_ulog_message("F", ":".join(form).encode()) for form in forms]
    parts += [parameter(name, value) for name, value in (parameters or {}).items()]
    records: list[tuple[int, bytes]] = []
    for number, topic in enumerate(topics):
        body = struct.pack("<BH", topic.instance, number) + topic.name.encode()
        parts.append(_ulog_message("A", body))
        packer = struct.Struct(topic.struct)
        for row in topic.rows:
            body = struct.pack("<H", number) + packer.pack(*row)
            records.append((row[0], _ulog_message("D", body)))
    for boot_us, level, text in texts:
        body = level.encode() + struct.pack("<Q", boot_us) + text.encode()
        records.append((boot_us, _ulog_message("L", body)))
    ordered = [raw for _, raw in sorted(records, key=lambda each: each[0])]
    gaps = [_ulog_message("O", struct.pack("<H", length)) for length in dropouts]
    return b"".join([*parts, *ordered[:1], *gaps, *ordered[1:]])


def px4_topics() -> list[UlogTopic]:
    """Return the topics of the made flight."""
    at = list(times_us())
    motion = [(t, sway(t * 1e-6)) for t in at]
    slow = at[::10]
    armed = [ARMED_S <= t * 1e-6 < DISARMED_S for t in slow]
    aloft = [LIFTED_S <= t * 1e-6 < LANDED_S for t in slow]
    utc = [BOOT_UTC_US + t for t in slow]
    return [
        UlogTopic("vehicle_attitude", "uint64_t timestamp;float[4] q;",
                  [(t, *quaternion(m.roll, m.pitch, m.yaw)) for t, m in motion]),
        UlogTopic("vehicle_local_position",
                  "uint64_t timestamp;float x;float y;float z;float vx;float vy;float vz;",
                  [(t, *m.position, *m.velocity) for t, m in motion]),
        UlogTopic("vehicle_local_position_setpoint",
                  "uint64_t timestamp;float vx;float vy;float vz;float yawspeed;",
                  [(t, *m.velocity, 0.0) for t, m in motion]),
        UlogTopic("vehicle_status",
                  "uint64_t timestamp;uint8_t arming_state;uint8_t nav_state;uint8_t system_type;"
                  "uint8_t system_id;bool failsafe;",
                  [(t, 2 if a else 1, 14 if a else 4, 2, 7, False)
                   for t, a in zip(slow, armed, strict=True)]),
        UlogTopic("vehicle_land_detected", "uint64_t timestamp;bool landed;",
                  [(t, not a) for t, a in zip(slow, aloft, strict=True)]),
        UlogTopic("battery_status", "uint64_t timestamp;float voltage_v;float remaining;",
                  [(t, 16.0 - t * 1e-8, 0.9 - t * 1e-8) for t in slow]),
        UlogTopic("sensor_gps",
                  "uint64_t timestamp;uint64_t time_utc_usec;uint8_t fix_type;"
                  "uint8_t satellites_used;double latitude_deg;double longitude_deg;float hdop;",
                  [(t, u, 3, 12, 47.1, 8.2, 0.8) for t, u in zip(slow, utc, strict=True)]),
        UlogTopic("actuator_motors", "uint64_t timestamp;float[4] control;",
                  [(t, 0.5, 0.5, 0.5, 1.0 if a else 0.0)
                   for t, a in zip(slow, aloft, strict=True)]),
        UlogTopic("sensor_accel", "uint64_t timestamp;float x;", [(t, 1.0) for t in slow]),
        UlogTopic("sensor_accel", "uint64_t timestamp;float x;", [(t, 2.0) for t in slow], 1),
        UlogTopic("debug_key_value", "uint64_t timestamp;char[10] key;float value;",
                  [(slow[0], b"depth", 3.5)]),
    ]  # fmt: skip


def px4_log(**more: Any) -> bytes:
    """Return the made flight as PX4 logs it."""
    texts = [(2_000_000, "6", "[commander] Armed by external command\t"),
             (20_000_000, "4", "w" * 70)]  # fmt: skip
    given: dict[str, Any] = {"texts": texts, "parameters": {"MPC_XY_VEL_MAX": 12.0, "MAV_TYPE": 2}}
    return ulog(px4_topics(), **{**given, **more})


FLASH_CODES = {"Q": "Q", "f": "f", "B": "B", "c": "h", "C": "H", "L": "i", "N": "16s", "Z": "64s",
               "n": "4s", "I": "I", "H": "H", "e": "i", "b": "b", "d": "d"}  # fmt: skip


class FlashType(NamedTuple):
    """A record's definition: its number, name, format characters, fields and units of FMTU."""

    number: int
    name: str
    format: str
    fields: str
    units: str = ""

    @property
    def struct(self) -> str:
        return "<" + "".join(FLASH_CODES[c] for c in self.format)

    def record(self, *values: Any) -> bytes:
        return b"\xa3\x95" + bytes([self.number]) + struct.pack(self.struct, *values)

    def definition(self) -> bytes:
        size = struct.calcsize(self.struct) + 3
        texts = (self.name.encode(), self.format.encode(), self.fields.encode())
        return b"\xa3\x95\x80" + struct.pack("<BB4s16s64s", self.number, size, *texts)


FMTU = FlashType(131, "FMTU", "QBNN", "TimeUS,FmtType,UnitIds,MultIds")
UNIT = FlashType(132, "UNIT", "QbZ", "TimeUS,Id,Label")
ATT = FlashType(140, "ATT", "QcccccC", "TimeUS,DesRoll,Roll,DesPitch,Pitch,DesYaw,Yaw", "sdddddd")
XKF1 = FlashType(141, "XKF1", "QBffffff", "TimeUS,C,VN,VE,VD,PN,PE,PD", "s#nnnmmm")
MODE = FlashType(142, "MODE", "QBBB", "TimeUS,Mode,ModeNum,Rsn")
ARM = FlashType(143, "ARM", "QBI", "TimeUS,ArmState,ArmChecks")
EV = FlashType(144, "EV", "QB", "TimeUS,Id")
ERR = FlashType(145, "ERR", "QBB", "TimeUS,Subsys,ECode")
MSG = FlashType(146, "MSG", "QZ", "TimeUS,Message")
PARM = FlashType(147, "PARM", "QNf", "TimeUS,Name,Value")
BAT = FlashType(148, "BAT", "QBffB", "TimeUS,Inst,Volt,Curr,RemPct", "s#vA%")
GPS = FlashType(149, "GPS", "QBBIHBCLLeffff",
                "TimeUS,I,Status,GMS,GWk,NSats,HDop,Lat,Lng,Alt,Spd,GCrs,VZ,Yaw")  # fmt: skip
RCOU = FlashType(150, "RCOU", "QHHHH", "TimeUS,C1,C2,C3,C4", "sYYYY")
STAT = FlashType(151, "STAT", "QBfB", "TimeUS,isFlying,isFlyProb,Armed")
TYPES = (FMTU, UNIT, ATT, XKF1, MODE, ARM, EV, ERR, MSG, PARM, BAT, GPS, RCOU, STAT)
UNITS = {"s": "s", "d": "deg", "n": "m/s", "m": "m", "v": "V", "A": "A", "%": "%", "#": "instance",
         "Y": "us"}  # fmt: skip
FIXED_OFFSET_S = 315_964_800 - 18  # GPS time began in 1980; it is 18 s ahead


def flash_head() -> bytes:
    itself = FlashType(128, "FMT", "BBnNZ", "Type,Length,Name,Format,Columns")
    parts = [itself.definition(), *(each.definition() for each in TYPES)]
    parts += [UNIT.record(1000, ord(key), unit.encode()) for key, unit in UNITS.items()]
    for each in TYPES:
        if each.units:
            blank = b"-" * len(each.units)
            parts.append(FMTU.record(1000, each.number, each.units.encode(), blank))
    return b"".join(parts)


def _flash_motion() -> list[tuple[int, bytes]]:
    found = []
    for t in times_us():
        m = sway(t * 1e-6)
        angles = [round(math.degrees(a) * 100) for a in (m.roll, m.pitch, m.yaw)]
        yaw = angles[2] % 36_000
        found.append((t, ATT.record(t, angles[0], angles[0], angles[1], angles[1], 0, yaw)))
        for core in (0, 1):
            place = [value + core for value in m.position]
            found.append((t, XKF1.record(t, core, *m.velocity, *place)))
    return found


def _flash_slow() -> list[tuple[int, bytes]]:
    found = []
    for t in times_us(500_000):
        week, rest_s = divmod((BOOT_UTC_US + t) * 1e-6 - FIXED_OFFSET_S, 604_800)
        fix = (3, round(rest_s * 1000), int(week), 12, 80, 471_000_000, 82_000_000, 40_000)
        found.append((t, GPS.record(t, 0, *fix, 1.0, 90.0, 0.0, 0.0)))
        found.append((t, BAT.record(t, 0, 16.0, 5.0, 90)))
        aloft = LIFTED_S <= t * 1e-6 < LANDED_S
        found.append((t, RCOU.record(t, 1500, 1500, 1500, 2000 if aloft else 1000)))
    return found


def ardupilot_log(more: Sequence[tuple[int, bytes]] = (), firmware: str = "ArduCopter") -> bytes:
    """Return the made flight as ArduPilot logs it, with more records in it."""
    armed, lifted, landed, disarmed = (
        int(s * 1e6) for s in (ARMED_S, LIFTED_S, LANDED_S, DISARMED_S)
    )
    events = [
        (1000, MSG.record(1000, f"{firmware} V4.5.7 (2a3dc4b7)".encode())),
        (1000, PARM.record(1000, b"SYSID_THISMAV", 7.0)),
        (1000, PARM.record(1000, b"FRAME_CLASS", 2.0)),
        (1000, PARM.record(1000, b"WPNAV_SPEED", 500.0)),
        (400_000, MODE.record(400_000, 0, 0, 1)),
        (armed, ARM.record(armed, 1, 0)),
        (3_000_000, MODE.record(3_000_000, 4, 4, 1)),
        (lifted, EV.record(lifted, 28)),
        (20_000_000, PARM.record(20_000_000, b"WPNAV_SPEED", 700.0)),
        (landed, EV.record(landed, 18)),
        (disarmed, ARM.record(disarmed, 0, 0)),
    ]
    records = [*events, *_flash_motion(), *_flash_slow(), *more]
    return flash_head() + b"".join(raw for _, raw in sorted(records, key=lambda each: each[0]))
