"""Packets are found whole in any stream of bytes, and nothing else is taken for one."""

from hypothesis import given
from hypothesis import strategies as st
from pymavlink.dialects.v20 import common

from flightstack.mavlink.packets import PacketSplitter, message_id, source_of, split_packets


def heartbeat(sequence: int = 0, *, system: int = 3, component: int = 1) -> bytes:
    protocol = common.MAVLink(None, system, component)
    protocol.seq = sequence
    return bytes(common.MAVLink_heartbeat_message(2, 12, 81, 0x10000, 3, 3).pack(protocol))


def unknown_message(payload: bytes = b"payload") -> bytes:
    return bytes([0xFD, len(payload), 0, 0, 0, 1, 1, 0xFF, 0xFF, 0x42]) + payload + b"\0\0"


def test_cuts_a_datagram_into_its_packets() -> None:
    packets = [heartbeat(number) for number in range(3)]
    assert split_packets(b"".join(packets)) == (packets, sum(map(len, packets)))


def test_reads_id_and_source() -> None:
    packet = heartbeat(system=7, component=191)
    assert (message_id(packet), source_of(packet)) == (0, (7, 191))


def test_takes_mavlink_1() -> None:
    message = common.MAVLink_heartbeat_message(2, 12, 81, 0x10000, 3, 3)
    packet = bytes(message.pack(common.MAVLink(None, 5, 6), force_mavlink1=True))
    assert split_packets(packet)[0] == [packet]
    assert (message_id(packet), source_of(packet)) == (0, (5, 6))


def test_takes_signed_packets_whole() -> None:
    protocol = common.MAVLink(None, 1, 1)
    protocol.signing.secret_key = bytes(32)
    protocol.signing.sign_outgoing = True
    packet = bytes(common.MAVLink_heartbeat_message(2, 12, 81, 0, 3, 3).pack(protocol))
    assert len(packet) == len(heartbeat()) + 13
    assert split_packets(packet + heartbeat())[0] == [packet, heartbeat()]


def test_takes_a_message_that_the_dialect_lacks() -> None:
    assert split_packets(unknown_message() + heartbeat())[0] == [unknown_message(), heartbeat()]


def test_a_damaged_packet_costs_only_itself() -> None:
    damaged = bytearray(heartbeat(1))
    damaged[12] ^= 0x40
    stream = heartbeat(0) + bytes(damaged) + heartbeat(2)
    assert split_packets(stream)[0] == [heartbeat(0), heartbeat(2)]


@given(noise=st.binary(max_size=40).filter(lambda noise: not {0xFD, 0xFE} & set(noise)))
def test_noise_before_a_packet_is_passed_over(noise: bytes) -> None:
    assert split_packets(noise + heartbeat())[0] == [heartbeat()]


@given(noise=st.binary(max_size=600))
def test_any_bytes_do_no_harm(noise: bytes) -> None:
    packets, used = split_packets(noise)
    assert 0 <= used <= len(noise)
    assert all(packet in noise for packet in packets)


@given(cuts=st.lists(st.integers(1, 30), max_size=20))
def test_a_stream_may_be_cut_anywhere(cuts: list[int]) -> None:
    packets = [heartbeat(number) for number in range(5)]
    stream = b"".join(packets)
    splitter = PacketSplitter()
    found = []
    for cut in cuts:
        found += splitter.split(stream[:cut])
        stream = stream[cut:]
    assert found + splitter.split(stream) == packets
