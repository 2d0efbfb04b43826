"""In lockstep a flight is a function of what is sent, whatever the speed, to the last bit."""

import itertools
import struct
import time
from typing import Any, NamedTuple

import numpy as np
import pytest
from pymavlink.dialects.v20 import development as mavlink

from tests.wire.stream_viewer import StreamViewer
from tests.wire.vehicle_process import Vehicle, is_from

pytestmark = pytest.mark.flight
IMAGES = 420  # 21 s: some 8 until it can be armed, take-off, and a flight in offboard
ARM_AT, TAKE_OFF_AT, OFFBOARD_AT = 220, 225, 320
TRUTH_US = 20_000
NAN = float("nan")


class Truth(NamedTuple):
    """One HIL_STATE_QUATERNION, as bytes: equal only if every bit is."""

    time_us: int
    payload: bytes


def fly(vehicle: Vehicle, delays: np.random.Generator | None, images: int = IMAGES) -> list[Truth]:
    """Fly a fixed plan, answering each image, some late; give the truth at every 20 ms."""
    api, truths = vehicle.api, []
    api.wait_for(is_from(100, "HEARTBEAT"))
    api.command(511, mavlink.MAVLINK_MSG_ID_HIL_STATE_QUATERNION, TRUTH_US)
    api.wait_for("COMMAND_ACK")
    api.command(512, 269, target=(1, 100))
    uri = api.wait_for("VIDEO_STREAM_INFORMATION").uri
    with StreamViewer(uri) as viewer:
        for number in range(images):
            part = viewer.read()
            assert part.sequence == number  # none is missed, none comes before its answer
            if number > 0:  # the first was announced before we came
                truths += take_truths(api, part.time_us)
            if delays is not None and delays.random() < 0.1:
                time.sleep(delays.uniform(0.0, 0.02))
            for message in plan(number):
                api.send(message)
            api.send(setpoint(number, part.time_us))
    return truths


def take_truths(api: Any, until_us: int) -> list[Truth]:
    """Take what came until the image's trigger."""
    truths = []
    for message in api.messages():
        if message.get_type() == "HIL_STATE_QUATERNION":
            truths.append(Truth(message.time_usec, bytes(message.get_msgbuf()[10:-2])))
        if message.get_type() == "CAMERA_TRIGGER" and message.time_usec == until_us:
            return truths
    raise AssertionError(f"no trigger of the image at {until_us} us")


def altitude_m(truth: Truth) -> float:
    """Read HIL_STATE_QUATERNION.alt."""
    return float(struct.unpack_from("<i", truth.payload, 44)[0]) / 1e3


def plan(number: int) -> list[Any]:
    commands = {
        ARM_AT: (400, [1.0] + [0.0] * 6),
        TAKE_OFF_AT: (22, [NAN] * 7),
        OFFBOARD_AT: (176, [1.0, 6.0] + [0.0] * 5),
    }
    if number not in commands:
        return []
    command, params = commands[number]
    return [mavlink.MAVLink_command_long_message(1, 1, command, 0, *params)]


def setpoint(number: int, time_us: int) -> Any:
    forward = 2.0 if number > OFFBOARD_AT + 10 else 0.0
    rate = 0.4 if number > OFFBOARD_AT + 40 else 0.0
    velocity = (forward, 0.3 * forward, -0.2 * forward)
    return mavlink.MAVLink_set_position_target_local_ned_message(
        time_us // 1000, 1, 1, 8, 0x5C7, 0.0, 0.0, 0.0, *velocity, 0.0, 0.0, 0.0, 0.0, rate
    )


def test_the_same_messages_fly_the_same_flight_at_any_speed() -> None:
    flights = []
    for speed_factor, delays in (
        ("0", None),
        ("0", np.random.default_rng(1)),
        ("10", np.random.default_rng(2)),
    ):
        with Vehicle("-q", "--lockstep", f"--speed-factor={speed_factor}") as vehicle:
            flights.append(fly(vehicle, delays))
    first = flights[0]
    assert len(first) > 0.95 * IMAGES * 50_000 / TRUTH_US
    gaps = {b.time_us - a.time_us for a, b in itertools.pairwise(first[1:])}
    assert gaps == {TRUTH_US}
    assert altitude_m(first[-1]) - altitude_m(first[1]) > 1.5  # it flew
    for other in flights[1:]:
        assert other == first


def test_time_stands_until_the_first_image_is_answered_and_the_vehicle_can_be_asked() -> None:
    with Vehicle("-q", "--lockstep", "--speed-factor=0") as vehicle:
        beats = [vehicle.gcs.wait_for(is_from(1, "HEARTBEAT")) for _ in range(3)]
        assert {beat.custom_mode for beat in beats} == {0x03040000}
        vehicle.gcs.send(mavlink.MAVLink_param_request_list_message(1, 1))
        count = vehicle.gcs.wait_for("PARAM_VALUE").param_count
        for _ in range(count):
            vehicle.gcs.wait_for("PARAM_VALUE")
        vehicle.gcs.send(mavlink.MAVLink_timesync_message(0, 5))
        answer = vehicle.gcs.wait_for("TIMESYNC")
        assert (answer.tc1, answer.ts1) == (0, 5)


def test_time_runs_free_when_the_viewer_leaves() -> None:
    with Vehicle("-q", "--lockstep", "--speed-factor=0") as vehicle:
        vehicle.api.wait_for(is_from(100, "HEARTBEAT"))
        vehicle.api.command(512, 269, target=(1, 100))
        uri = vehicle.api.wait_for("VIDEO_STREAM_INFORMATION").uri
        with StreamViewer(uri) as viewer:
            part = viewer.read()
            vehicle.api.send(setpoint(0, part.time_us))
            viewer.read()
        begun_s = time.monotonic()
        first_ms = vehicle.api.wait_for("ATTITUDE").time_boot_ms
        vehicle.api.wait_for(
            lambda m: m.get_type() == "ATTITUDE" and m.time_boot_ms >= first_ms + 1000
        )
        assert time.monotonic() - begun_s > 0.7  # real time, although --speed-factor is 0


def test_a_late_camera_is_answered_by_the_stamps_of_its_images() -> None:
    flights = []
    for delays in (None, np.random.default_rng(3)):
        with Vehicle(
            *("-q", "--lockstep", "--speed-factor=0", "--condition=camera.latency_s=0.1")
        ) as vehicle:
            flights.append(fly(vehicle, delays, images=60))
    first, other = flights
    assert first == other
    stamps = [truth.time_us for truth in first]
    delivered_us = 59 * 50_000 + 100_000  # and the telemetry is of that moment
    assert delivered_us - TRUTH_US < stamps[-1] <= delivered_us
