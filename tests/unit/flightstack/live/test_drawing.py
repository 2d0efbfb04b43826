"""What is drawn of a flight, read back from the recording by rerun itself."""

import math
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from pymavlink.dialects.v20 import all as mavlink

from flightstack.live.link import Questions
from flightstack.live.scene.track import FollowedTrack
from flightstack.live.watching import watched
from flightstack.logs import read
from flightstack.logs.columns.log import Log
from flightstack.logs.flight.flight import Flight
from tests.unit.flightstack.logs.made_flights import (
    BOOT_US,
    GATES,
    VEHICLE,
    Recorder,
    beat,
    make_flight,
)

DRAWN = (
    *(f"/velocity/{axis}/{kind}" for axis in ("forward", "right", "down", "yaw_rate")
      for kind in ("commanded", "flown")),
    *(f"/uncertainty/{part}" for part in ("aleatoric", "epistemic", "perceptual")),
    *(f"/world/{what}" for what in ("gates", "path", "commanded", "flown")),
    "/texts",
    "/camera/image",
)  # fmt: skip


@pytest.fixture
def log(tmp_path: Path) -> Log:
    path = tmp_path / "flight.tlog"
    path.write_bytes(make_flight(4.0))
    return read(path)


def test_all_of_a_flight_is_drawn_whole_or_in_pieces(log: Log) -> None:
    pytest.importorskip("rerun")
    from flightstack.live.scene.drawing import FlightDrawing  # noqa: PLC0415

    drawing = FlightDrawing("made", None, None)
    edges = np.linspace(log.time_us[0], log.time_us[-1] + 1, 6).astype(int).tolist()
    taken = b""
    for start_us, end_us in pairwise(edges):
        drawing.draw(log.select(start_us=start_us, end_us=end_us))
        drawing.draw_image(BOOT_US, np.zeros((64, 64, 3), np.uint8))
        taken += drawing.take()
    assert taken.startswith(b"RRF")
    missing = [path for path in DRAWN if path.encode() not in taken]
    assert missing == []


def test_a_track_tells_place_and_attitude_by_the_vehicle_s_clock(log: Log) -> None:
    flight, track = Flight(log), FollowedTrack()
    track.learn(log)
    assert track.system == 1
    late = flight.decisions.stamp_us[-20:]
    position, velocity = track.motion_at(late)
    assert np.isfinite(position).all()
    moved = np.diff(position, axis=0) / (np.diff(late)[:, None] * 1e-6)
    np.testing.assert_allclose(moved, velocity[1:], atol=0.3)
    times_us = track.vehicle_us(log.time_us[:1])
    assert abs(int(times_us[0]) - BOOT_US) < 20_000


def test_what_is_not_known_is_asked_for_and_nothing_else(log: Log) -> None:
    questions = Questions()
    assert list(questions.open(1)) == []  # nobody was heard who could answer
    whole = log.select(types=["HEARTBEAT", "STATUSTEXT"])
    questions.hear(whole)
    assert all(message.get_type() != "HEARTBEAT" for message in questions.open(1))
    questions.hear(log.select(types=["MISSION_ITEM_INT"]))
    assert questions._gates == set(range(GATES))


def test_a_stream_is_asked_for_as_one_who_only_watches() -> None:
    assert watched("http://127.0.0.1:8090/stream") == "http://127.0.0.1:8090/stream?watch"
    assert watched("http://host/video?channel=2") == "http://host/video?channel=2"


def test_nothing_that_is_said_ends_the_drawing(tmp_path: Path) -> None:
    pytest.importorskip("rerun")
    from flightstack.live.scene.drawing import FlightDrawing  # noqa: PLC0415

    said = Recorder()
    said.add(VEHICLE, beat(0, armed=True))
    for value in (math.nan, math.inf, -3e38):
        attitude = mavlink.MAVLink_attitude_message(2**32 - 1, *[value] * 6)
        said.add(VEHICLE, attitude)
        place = mavlink.MAVLink_local_position_ned_message(0, *[value] * 6)
        said.add(VEHICLE, place)
        for stamp_us in (2**64 - 1, 2**63, 0):
            data = [value] * 58
            said.add(191, mavlink.MAVLink_debug_float_array_message(stamp_us, b"decision", 0, data))
    said.add(VEHICLE, mavlink.MAVLink_statustext_message(255, b"\xff\x1b[2J" * 10))
    path = tmp_path / "hostile.tlog"
    path.write_bytes(b"".join(said.parts))
    drawing = FlightDrawing("hostile", None, None)
    drawing.draw(read(path))
    assert drawing.take()
