"""Packets become pictures at the marker; what lacks one is left out, with all that builds on it."""

import socket
import struct
from collections.abc import Iterator

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from flightstack.arrays import Rgb
from flightstack.camera.video.rtp import PictureAssembler
from sitl.process.streams.video import VideoSender
from sitl.records.images import Image

pytest.importorskip("av")
RATE_HZ, SIZE_PX, COUNT = 20, 64, 45  # a whole picture each second


def noise(number: int) -> Rgb:
    """A picture that fills more than one packet."""
    return np.random.default_rng(number).integers(0, 255, (SIZE_PX, SIZE_PX, 3)).astype(np.uint8)


@pytest.fixture(scope="module")
def packets() -> list[bytes]:
    """What the simulator's video sends for some pictures."""
    found: list[bytes] = []
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as viewer:
        viewer.bind(("127.0.0.1", 0))
        viewer.settimeout(1.0)
        sender = VideoSender(viewer.getsockname(), size_px=SIZE_PX, rate_hz=RATE_HZ)
        for number in range(COUNT):
            sender.publish(Image(time_us=50_000 * number, sequence=number, rgb=noise(number)))
            while not found or not found[-1][1] & 0x80 or not _is_of(found, number + 1):
                found.append(viewer.recv(2048))
        sender.close()
    return found


def _is_of(packets: list[bytes], pictures: int) -> bool:
    return sum(packet[1] >> 7 for packet in packets) == pictures


def stamps(packets: Iterator[bytes] | list[bytes]) -> list[float]:
    assembler = PictureAssembler()
    found = [picture.stamp_s for packet in packets if (picture := assembler.take(packet))]
    return [stamp_s - found[0] for stamp_s in found]


def test_each_picture_is_there_with_its_last_packet(packets: list[bytes]) -> None:
    assert len(packets) > 2 * COUNT  # pictures in fragments
    assert stamps(packets) == pytest.approx(np.arange(COUNT) / RATE_HZ, abs=1e-4)


def test_a_lost_packet_takes_what_builds_on_it(packets: list[bytes]) -> None:
    ends = [n for n, packet in enumerate(packets) if packet[1] & 0x80]
    lost = ends[9] + 1  # of picture 10
    left = np.r_[0:10, 20:COUNT] / RATE_HZ
    assert stamps(packets[:lost] + packets[lost + 1 :]) == pytest.approx(left, abs=1e-4)


def test_where_no_whole_picture_ever_comes_others_are_shown_after_a_while() -> None:
    """An encoder that refreshes in stripes sends slices of kind 1 alone."""
    packets = [
        struct.pack(">BBHII", 0x80, 0xE0, n + (n > 3), 4500 * n, 7) + b"\x61\x80\x01"
        for n in range(80)
    ]
    seen = np.round(np.array(stamps(packets)) * RATE_HZ).astype(int).tolist()
    assert seen == [0, 1, 2, 3, *range(45, 80)]


def test_stamps_go_on_where_32_bits_begin_anew() -> None:
    packets = [
        struct.pack(">BBHII", 0x80, 0xE0, n, (4500 * n - 9000) % (1 << 32), 7) + b"\x65\x80\x01"
        for n in range(5)
    ]
    assert stamps(packets) == pytest.approx([0.0, 0.05, 0.1, 0.15, 0.2])


@given(st.lists(st.binary(max_size=60), max_size=20))
def test_any_bytes_are_survived(junk: list[bytes]) -> None:
    assembler = PictureAssembler()
    for datagram in junk:
        assembler.take(datagram)
        assembler.take(b"\x80\xe0" + datagram)
    whole = [struct.pack(">BBHII", 0x80, 0xE0, n, n, 7) + b"\x65\x80\x01" for n in range(2)]
    assert [assembler.take(packet) for packet in whole][-1] is not None


def test_another_stream_begins_with_nothing_of_the_one_before() -> None:
    def packets(source: int, numbers: list[int]) -> list[bytes]:
        return [
            struct.pack(">BBHII", 0x80, 0xE0, n, 4500 * n, source) + b"\x61\x80\x01"
            for n in numbers
        ]

    assembler = PictureAssembler()
    seen = [assembler.take(packet) for packet in packets(7, [900, 902])]
    assert [picture is not None for picture in seen] == [True, False]  # one was lost
    assert assembler.take(packets(8, [0])[0]) is not None
