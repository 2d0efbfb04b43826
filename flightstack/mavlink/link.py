"""Speak MAVLink with one vehicle: every packet is logged, only what is needed is decoded.

The first PX4 heard (component 1, a HEARTBEAT that names an autopilot) is taken for the vehicle, and
the others are remembered, until the choice is settled. From then on datagrams from other addresses
are dropped, so that nobody else can pose as it by port.
Under a signing key, what is not signed with it is refused and not even logged. Messages that need
no signature are logged but not heeded: a forged HEARTBEAT could end a flight. A PX4 whose clock has
stood still while it was off signs with old timestamps. It is not believed, but spoken to: our own
HEARTBEAT tells it the time, as the signing protocol has it.
"""

from collections import Counter
from typing import Any, TypeAlias

from pymavlink.dialects.v20 import common

from flightstack.clock import VehicleClock
from flightstack.mavlink.identity import VehicleIdentity, speaks_for_a_vehicle
from flightstack.mavlink.packets import boot_time_us, identify, is_signed
from flightstack.mavlink.signing import Signing, Verdict
from flightstack.mavlink.tlog import TlogWriter
from flightstack.mavlink.transport import Address, Transport
from flightstack.mavlink_numbers import (
    AUTOPILOT_COMPONENT,
    CAMERA_COMPONENT,
    COMPANION_COMPONENT,
    HEADER_V1,
    HEADER_V2,
    MAGIC_V2,
    REFEREE_COMPONENT,
)

Message: TypeAlias = Any  # pymavlink's classes carry no types

# Each begins with time_boot_ms, and PX4 streams them at 30 Hz or more.
STAMPED = frozenset(
    {
        common.MAVLINK_MSG_ID_ATTITUDE,
        common.MAVLINK_MSG_ID_ATTITUDE_QUATERNION,
        common.MAVLINK_MSG_ID_LOCAL_POSITION_NED,
        common.MAVLINK_MSG_ID_GLOBAL_POSITION_INT,
    }
)
STEP_US = 2_000_000  # between two stamps, either way: no link keeps a packet for longer
OUTAGE_US = 600_000_000  # ahead: further than any outage that a flight outlasts
UNBROKEN_S = 0.5  # wall time: while a vehicle's stamps go on so often, it has not restarted
HEARTBEAT_TYPE = 4  # where its type stands
# Only the newest of these matters: they are decoded once a drain.
COALESCED = frozenset(
    {
        common.MAVLINK_MSG_ID_ATTITUDE,
        common.MAVLINK_MSG_ID_LOCAL_POSITION_NED,
        common.MAVLINK_MSG_ID_POSITION_TARGET_LOCAL_NED,
    }
)
NOBODY = -1
NOTHING: frozenset[int] = frozenset()
MAX_HEARD = 32  # autopilots: of more, nobody chooses
WANTED = {
    AUTOPILOT_COMPONENT: frozenset(
        {
            common.MAVLINK_MSG_ID_ATTITUDE,
            common.MAVLINK_MSG_ID_HEARTBEAT,
            common.MAVLINK_MSG_ID_COMMAND_ACK,
            common.MAVLINK_MSG_ID_EXTENDED_SYS_STATE,
            common.MAVLINK_MSG_ID_HOME_POSITION,
            common.MAVLINK_MSG_ID_LOCAL_POSITION_NED,
            common.MAVLINK_MSG_ID_POSITION_TARGET_LOCAL_NED,
            common.MAVLINK_MSG_ID_STATUSTEXT,
        }
    ),
    REFEREE_COMPONENT: frozenset(
        {
            common.MAVLINK_MSG_ID_MISSION_COUNT,
            common.MAVLINK_MSG_ID_MISSION_CURRENT,
            common.MAVLINK_MSG_ID_MISSION_ITEM_INT,
            common.MAVLINK_MSG_ID_MISSION_ITEM_REACHED,
            common.MAVLINK_MSG_ID_STATUSTEXT,
        }
    ),
    CAMERA_COMPONENT: frozenset(
        {
            common.MAVLINK_MSG_ID_CAMERA_TRIGGER,
            common.MAVLINK_MSG_ID_COMMAND_ACK,
            common.MAVLINK_MSG_ID_VIDEO_STREAM_INFORMATION,
        }
    ),
}


class Link:
    """The companion's end of the link; for one thread."""

    def __init__(
        self,
        transport: Transport,
        tlog: TlogWriter,
        clock: VehicleClock,
        *,
        signing: Signing | None = None,
        system: int | None = None,
    ) -> None:
        """Listen; `system` is the only one that may be the vehicle."""
        self.tlog = tlog
        self.clock = clock
        self.vehicle: VehicleIdentity | None = None
        self.refused: Counter[Verdict] = Counter()  # packets, by reason
        self._signing = signing
        self._stale_address: Address | None = None  # of one who may be the vehicle
        self._vehicle_system = NOBODY
        self._wanted_system = system
        self._settled = False
        self.heard: list[VehicleIdentity] = []  # autopilots, until one of them is settled on
        self._transport = transport
        self._heard_s = clock.wall_s()
        self.restarts = 0  # of the vehicle, by its own stamps
        self.others: dict[int, int] = {}  # MAV_TYPE of each further component of its system
        self._jumped_us: int | None = None  # the last stamp, where it does not go on
        self._went_on_s = clock.wall_s()  # when one last did
        self._boot_us = 0  # its newest stamp
        self._protocol = common.MAVLink(None, srcSystem=1, srcComponent=COMPANION_COMPONENT)
        self._newest: dict[int, bytes] = {}
        self._wanted = WANTED

    @property
    def system_id(self) -> int:
        """The system that we belong to: the vehicle's; 1 until it is heard."""
        return 1 if self.vehicle is None else self.vehicle.system_id

    @property
    def silence_s(self) -> float:
        """Wall time since the vehicle was last heard; endless where its end has closed."""
        return float("inf") if self.closed else self.clock.wall_s() - self._heard_s

    @property
    def closed(self) -> bool:
        """Whether the vehicle's end has closed for good."""
        return self._transport.closed

    def fileno(self) -> int:
        """Return what a selector waits on."""
        return self._transport.fileno()

    def drain(self) -> list[Message]:
        """Take in all that has arrived; return the decoded messages that the companion uses."""
        messages: list[Message] = []
        for packets, address in self._transport.receive():
            if self._settled and self.vehicle is not None and address != self.vehicle.address:
                continue
            for packet in packets:
                if self._signing is None or self._admits(packet, address, self._signing):
                    self._take(packet, address, messages)
        for packet in self._newest.values():
            self._decode(packet, messages)
        self._newest.clear()
        return messages

    def send(self, *messages: Message) -> None:
        """Send messages as component 191 of the vehicle's system, together: in one datagram."""
        packets = [self._pack(message) for message in messages]
        address = self.vehicle.address if self.vehicle else self._stale_address
        if self._transport.send(b"".join(packets), address):
            for packet in packets:
                self.tlog.append(self.clock.elapsed_us, packet)

    @property
    def candidates(self) -> list[VehicleIdentity]:
        """Who of those heard may be the vehicle, in that order."""
        return [each for each in self.heard if self._may_be_the_vehicle(each)]

    def turn_to(self, vehicle: VehicleIdentity) -> None:
        """Speak with this one from now on, and forget what another has said of itself."""
        if self.vehicle is not None:
            self.clock.forget()
            self._jumped_us, self._boot_us = None, 0
            self.others.clear()
            self._newest.clear()
        self.vehicle, self._vehicle_system = vehicle, vehicle.system_id

    def settle(self) -> None:
        """Hear nobody else from now on."""
        self._settled = True
        if self.vehicle is not None:
            self._transport.listen_only_to(self.vehicle.address)

    def heed(self, number: int) -> None:
        """Decode a further message of the autopilot's from now on."""
        wanted = self._wanted[AUTOPILOT_COMPONENT] | {number}
        self._wanted = {**self._wanted, AUTOPILOT_COMPONENT: wanted}

    def close(self) -> None:
        """Write the log out and let go of the transport."""
        self.tlog.close()
        self._transport.close()

    def _pack(self, message: Message) -> bytes:
        self._protocol.srcSystem = self.system_id
        packet = bytes(message.pack(self._protocol))
        self._protocol.seq = (self._protocol.seq + 1) % 256
        return packet if self._signing is None else self._signing.sign(packet)

    def _admits(self, packet: bytes, address: Address | None, signing: Signing) -> bool:
        """Whether to heed a packet; what is neither heeded nor refused is logged."""
        verdict = signing.verify(packet)
        if verdict is Verdict.STALE:
            self._stale_address = address
        if verdict is Verdict.OPEN:
            self.tlog.append(self.clock.elapsed_us, packet)
        elif verdict is not Verdict.GENUINE:
            self.refused[verdict] += 1
        return verdict is Verdict.GENUINE

    def _take(self, packet: bytes, address: Address | None, messages: list[Message]) -> None:
        number, system, component = identify(packet)
        if not self._settled:
            self._meet(packet, number, (system, component), address)
        if system != self._vehicle_system or self._is_elsewhere(address):
            self.tlog.append(self.clock.elapsed_us, packet)
            return
        is_timely = True
        if component == AUTOPILOT_COMPONENT:
            self._heard_s = self.clock.wall_s()
            if number in STAMPED:
                is_timely = self._observe_stamp(boot_time_us(packet))
            elif number == common.MAVLINK_MSG_ID_POSITION_TARGET_LOCAL_NED:
                is_timely = abs(boot_time_us(packet) - self._boot_us) <= STEP_US
        self.tlog.append(self.clock.elapsed_us, packet)
        if not is_timely:  # whoever says this speaks of no time of this vehicle's
            return
        if number == common.MAVLINK_MSG_ID_HEARTBEAT and component not in WANTED:
            self._note_other(packet, component)
        if number in self._wanted.get(component, NOTHING):
            if number in COALESCED:
                self._newest[number] = packet
            else:
                self._decode(packet, messages)

    def _meet(
        self, packet: bytes, number: int, source: tuple[int, int], address: Address | None
    ) -> None:
        if number != common.MAVLINK_MSG_ID_HEARTBEAT or source[1] != AUTOPILOT_COMPONENT:
            return
        decoded: list[Message] = []
        self._decode(packet, decoded)
        if not decoded or not speaks_for_a_vehicle(decoded[0]):
            return
        met = VehicleIdentity(source[0], decoded[0].autopilot, address, is_signed(packet))
        if met not in self.heard and len(self.heard) < MAX_HEARD:
            self.heard.append(met)
        if self.vehicle is None and self._may_be_the_vehicle(met):
            self.turn_to(met)

    def _may_be_the_vehicle(self, met: VehicleIdentity) -> bool:
        return met.is_px4 and self._wanted_system in (None, met.system_id)

    def _is_elsewhere(self, address: Address | None) -> bool:
        return self.vehicle is not None and address != self.vehicle.address

    def _observe_stamp(self, stamp_us: int) -> bool:
        """Tell the time by a stamp; whether it is believed."""
        if not self._goes_on(stamp_us):
            return False
        if self._boot_us - stamp_us > STEP_US:
            self.restarts += 1
            self.clock.begin_anew(stamp_us)
        self._boot_us = stamp_us
        self.clock.observe(stamp_us)
        return True

    def _goes_on(self, stamp_us: int) -> bool:
        """Whether to believe a stamp, where nobody's odd packets shall move the vehicle's clock.

        It may be heard again after an outage: by two stamps that agree, or after a silence. And it
        may have restarted: by two that agree after a silence, not while its old time goes on.
        """
        ahead_us = stamp_us - self._boot_us
        if not self.clock.started or -STEP_US <= ahead_us <= STEP_US:
            self._jumped_us, self._went_on_s = None, self.clock.wall_s()
            return True
        agrees = self._jumped_us is not None and abs(stamp_us - self._jumped_us) <= STEP_US
        self._jumped_us = stamp_us
        was_silent = self.clock.wall_s() - self._went_on_s > UNBROKEN_S
        if 0 < ahead_us <= OUTAGE_US:
            return agrees or was_silent
        return agrees and was_silent

    def _note_other(self, packet: bytes, component: int) -> None:
        """Remember who else beats as part of the vehicle's system."""
        begin = (HEADER_V2 if packet[0] == MAGIC_V2 else HEADER_V1) + HEARTBEAT_TYPE
        if len(packet) > begin:
            self.others[component] = packet[begin]

    def _decode(self, packet: bytes, messages: list[Message]) -> None:
        try:
            messages.append(self._protocol.decode(bytearray(packet)))
        except common.MAVError:  # a field that the dialect refuses
            return
