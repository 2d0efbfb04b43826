"""Make datagrams that wish a vehicle ill, the same ones for the same seed.

Without a signing key, a packet that a pilot could have sent is obeyed, whoever sends it: that is
PX4's way, and no fault to be found. So `orders` chooses: with it, anything goes (the vehicle has a
key); without it, packets that would be an honest order are made absurd, or addressed to others.
"""

import random
import struct
from collections.abc import Callable, Iterator
from typing import Any

from pymavlink.dialects.v20 import development as mavlink
from pymavlink.generator.mavcrc import x25crc

MAX_UDP_BYTES = 65_000
NAMES = (b"COM_OF_LOSS_T", b"MPC_XY_VEL_MAX", b"MAV_SYS_ID", b"NAV_DLL_ACT", b"NO_SUCH", b"x" * 16)
PATHS = (
    *(b"../../../etc/passwd", b"/etc/passwd", b"log/../../x", b"..", b"/", b"@PARAM/param.pck"),
    *(b"a/" * 100, b"\xff" * 200, b"%2e%2e/etc/passwd", b"..\\..\\x", b"", b"mftp://../x"),
)
ABSURD = (
    *(float("nan"), float("inf"), float("-inf"), 3.4e38, -3.4e38, 1e-45, 2147483648.0, -1e9, 1e30),
)
REFUSED_WHEN_ABSURD = (176, 400, 410, 420, 511, 512, 31999, 65535)  # commands
ORDERS = {  # messages that a pilot sends: obeyed unless absurd, so never plain without a key
    *("COMMAND_LONG", "COMMAND_INT", "SET_MODE", "PARAM_SET", "SETUP_SIGNING", "MANUAL_CONTROL"),
    *("SET_POSITION_TARGET_LOCAL_NED", "SET_POSITION_TARGET_GLOBAL_INT", "SET_ATTITUDE_TARGET"),
    *("RC_CHANNELS_OVERRIDE", "MISSION_ITEM_INT", "MISSION_ITEM", "MISSION_COUNT"),
    *("MISSION_SET_CURRENT", "MISSION_CLEAR_ALL", "SET_GPS_GLOBAL_ORIGIN", "SET_HOME_POSITION"),
}

MESSAGES = sorted(mavlink.mavlink_map.items())


class Generator:
    """An endless source of hostile datagrams."""

    def __init__(self, seed: int, *, system: int = 1, orders: bool = False) -> None:
        """Aim at a vehicle's system; the same seed makes the same datagrams."""
        self._system = system
        self._ours = (system, 1)  # the autopilot
        self._random = random.Random(seed)  # noqa: S311  not for secrets: the same every time
        self._orders = orders
        self._heard: list[bytes] = []
        self._kinds: tuple[tuple[Callable[[], bytes], int], ...] = (
            (self._noise, 10),
            (self._mutated, 20),
            (self._any_message, 35),
            (self._order, 20),
            (self._file_request, 8),
            (self._crowd, 7),
        )

    def overhear(self, raw: bytes) -> None:
        """Remember a packet of somebody else, to change it and to send it again."""
        if len(self._heard) < 1000:
            self._heard.append(raw)

    def __iter__(self) -> Iterator[bytes]:
        makers = [make for make, _ in self._kinds]
        weights = [weight for _, weight in self._kinds]
        while True:
            for make in self._random.choices(makers, weights, k=256):
                yield make()

    def hello(self) -> bytes:
        """Make a HEARTBEAT of a harmless listener."""
        codec = mavlink.MAVLink(None, srcSystem=250, srcComponent=190)
        return bytes(mavlink.MAVLink_heartbeat_message(18, 8, 0, 0, 4, 3).pack(codec))

    def _noise(self) -> bytes:
        size = self._random.choice((0, 1, 7, 8, 12, 280, 1400, self._random.randrange(3000)))
        if self._random.random() < 0.001:
            size = MAX_UDP_BYTES
        return self._random.randbytes(size)

    def _mutated(self) -> bytes:
        """Change, cut, repeat or string together valid packets; most checksums are then wrong."""
        rng = self._random
        replayed = rng.random() < 0.5 and self._heard and self._orders
        data = bytearray(rng.choice(self._heard) if replayed else self._any_message())
        for _ in range(rng.choice((1, 1, 2, 8)) if not replayed else rng.randrange(2)):
            data[rng.randrange(len(data))] = rng.randrange(256)
        way = rng.randrange(4)
        if way == 0:
            return bytes(data[: rng.randrange(len(data))])
        if way == 1:
            return bytes(data) + rng.randbytes(rng.randrange(40)) + self._any_message()
        return bytes(data) * (rng.randrange(5) if way == 2 else 1)

    def _any_message(self) -> bytes:
        """Fill any message of the dialect with whatever its bytes can hold."""
        number, kind = self._random.choice(MESSAGES)
        if kind.msgname in ORDERS and not self._orders:
            return self._order()
        size = kind.unpacker.size
        payload = bytearray(self._fill(size))
        for field in ("target_system", "target_component"):
            if field in kind.fieldnames and self._random.random() < 0.7:
                payload[_place(kind, field)] = self._system if field == "target_system" else 1
        return self._packet(number, bytes(payload), kind.crc_extra)

    def _fill(self, size: int) -> bytes:
        rng = self._random
        floats = struct.pack("<f", rng.choice(ABSURD)) * (size // 4 + 1)
        return rng.choice(
            (rng.randbytes(size), bytes(size), b"\xff" * size, floats[:size], b"\x7f" * size)
        )

    def _order(self) -> bytes:
        """Give an order: an absurd one, unless orders are allowed."""
        rng = self._random
        make = rng.choice((self._command, self._setpoint, self._parameter, self._mode, self._list))
        message = make()
        return self._pack(message)

    def _command(self) -> Any:
        rng = self._random
        if self._orders:
            number = rng.choice((*REFUSED_WHEN_ABSURD, 16, 20, 21, 22, 84, 179, 185, 192, 246, 300))
            values = [rng.choice((*ABSURD, 0.0, 1.0, 6.0, 21196.0)) for _ in range(7)]
            target = self._ours
        else:
            number = rng.choice(REFUSED_WHEN_ABSURD)
            values = [rng.choice(ABSURD) for _ in range(7)]
            target = rng.choice(
                (self._ours, *((self._system, other) for other in (0, 25, 100)), (0, 0), (77, 7))
            )
        if rng.random() < 0.5:
            return mavlink.MAVLink_command_long_message(*target, number, 255, *values)
        x, y = rng.choice((-(2**31), 2**31 - 1, 0)), rng.choice((-(2**31), 2**31 - 1, 0))
        return mavlink.MAVLink_command_int_message(
            *(*target, rng.randrange(256), number, 1, 1, *values[:4], x, y, values[4])
        )

    def _setpoint(self) -> Any:
        rng = self._random
        values = [rng.choice(ABSURD) for _ in range(11)]
        stamp = rng.randrange(2**31, 2**32)
        frame, mask = rng.randrange(256), rng.randrange(2**16)
        kind = rng.randrange(3)
        if kind == 0:
            return mavlink.MAVLink_set_position_target_local_ned_message(
                *(stamp, *self._ours, rng.choice((1, 8, frame)), mask, *values)
            )
        if kind == 1:
            return mavlink.MAVLink_set_position_target_global_int_message(
                *(stamp, *self._ours, rng.choice((5, 6, 11, frame)), mask, 2**31 - 1, -(2**31)),
                *values[2:],
            )
        return mavlink.MAVLink_set_attitude_target_message(
            *(stamp, *self._ours, mask & 0xFF, values[:4], *values[4:8])
        )

    def _parameter(self) -> Any:
        rng = self._random
        name = rng.choice(NAMES)
        if rng.random() < 0.3:
            index = rng.choice((-1, -32768, 32767, 5000))
            return mavlink.MAVLink_param_request_read_message(*self._ours, name, index)
        absurd = [value for value in ABSURD if not 0.0 < value < 1.0]  # that may be in range
        return mavlink.MAVLink_param_set_message(*self._ours, name, rng.choice(absurd), 9)

    def _mode(self) -> Any:
        rng = self._random
        if self._orders and rng.random() < 0.5:
            return mavlink.MAVLink_set_mode_message(self._system, 1, rng.choice((1, 4, 6)) << 16)
        if rng.random() < 0.3:
            sticks = [rng.choice((-32768, 32767, -1001, 1001)) for _ in range(4)]
            return mavlink.MAVLink_manual_control_message(self._system, *sticks, 0xFFFF)
        return mavlink.MAVLink_set_mode_message(
            self._system, rng.randrange(256), 99 << 16 | 77 << 24
        )

    def _list(self) -> Any:
        rng = self._random
        kind = rng.choice((0, 1, 2, 255, 99))
        big = rng.choice((0xFFFF, 0xFFFE, 5000))
        return rng.choice(
            (
                mavlink.MAVLink_mission_count_message(*self._ours, big, kind),
                mavlink.MAVLink_mission_request_int_message(*self._ours, big, kind),
                mavlink.MAVLink_mission_request_list_message(*self._ours, kind),
                mavlink.MAVLink_mission_request_message(self._system, 25, big, kind),
                mavlink.MAVLink_mission_set_current_message(*self._ours, big),
                mavlink.MAVLink_param_request_list_message(*self._ours),
                mavlink.MAVLink_log_request_list_message(*self._ours, big, 0),
                mavlink.MAVLink_log_request_data_message(*self._ours, big, 2**32 - 1, 2**32 - 1),
                mavlink.MAVLink_log_erase_message(*self._ours),
                mavlink.MAVLink_ping_message(2**64 - 1, 2**32 - 1, 0, 0),
                mavlink.MAVLink_timesync_message(0, -(2**63)),
            )
        )

    def _file_request(self) -> bytes:
        rng = self._random
        data = rng.choice((*PATHS, rng.randbytes(rng.randrange(239))))[:239]
        header = struct.pack(
            "<HBBBBBBI",
            *(rng.randrange(2**16), rng.randrange(256), rng.choice((*range(20), 128, 255))),
            *(rng.choice((len(data), 239, 255)), rng.randrange(256), rng.randrange(2), 0),
            rng.choice((0, 1, 2**31, 2**32 - 1)),
        )
        payload = list((header + data).ljust(251, b"\0"))
        return self._pack(mavlink.MAVLink_file_transfer_protocol_message(0, *self._ours, payload))

    def _crowd(self) -> bytes:
        """Pretend to be somebody new, to fill whatever table there is."""
        kind = self._random.choice((1, 6, 18, 26, 255))
        return self._pack(mavlink.MAVLink_heartbeat_message(kind, 8, 0, 0, 4, 3))

    def _pack(self, message: Any) -> bytes:
        codec = mavlink.MAVLink(None, srcSystem=self._sender(), srcComponent=self._sender())
        return bytes(message.pack(codec))

    def _packet(self, number: int, payload: bytes, crc_extra: int) -> bytes:
        rng = self._random
        body = struct.pack(
            "<BBBBBBHB",
            *(len(payload), 0, rng.randrange(256), rng.randrange(256)),
            *(self._sender(), self._sender(), number & 0xFFFF, number >> 16),
        )
        return b"\xfd" + body + payload + struct.pack("<H", _checksum(body + payload, crc_extra))

    def _sender(self) -> int:
        return self._random.choice((1, 25, 100, 190, 191, 255, self._random.randrange(256)))


def _checksum(data: bytes, crc_extra: int) -> int:
    return int(x25crc(data + bytes((crc_extra,))).crc)


def _place(kind: Any, field: str) -> int:
    """Say where a one-byte field stands in the payload."""
    index = kind.ordered_fieldnames.index(field)
    layout = kind.unpacker.format
    sizes = [
        struct.calcsize(f"<{code}") * max(1, count)
        for code, count in zip(kind.native_format.decode()[1:], kind.array_lengths, strict=True)
    ]
    assert layout[0] == "<"  # noqa: S101  as pymavlink has it
    return sum(sizes[:index])
