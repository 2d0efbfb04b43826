"""The endpoint behind real loopback sockets."""

from collections import Counter
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from sitl.clock import TICK_US
from sitl.mavlink.wire.dialect import AUTOPILOT, CAMERA, REFEREE, mavlink
from sitl.mavlink.wire.packets import Packed, Received, wrap
from sitl.records.course import CourseEvent, CourseEventKind
from sitl.records.images import ImageStamp
from sitl.records.texts import StatusText
from tests.unit.sitl.mavlink.bench import EPOCH_US, Bench

GCS, ONBOARD = 6, 18
ASKER, PING = (77, 7), 0xA5A5  # a system and component that nobody else is
# All but the one that may hand over a key, after which only who has it is answered.
ANY = sorted(set(mavlink.mavlink_map) - {mavlink.MAVLINK_MSG_ID_SETUP_SIGNING})
ANSWERS = Counter({"PING": 1, "COMMAND_ACK": 1, "AUTOPILOT_VERSION": 1})


def heartbeat(kind: int) -> Any:
    return mavlink.MAVLink_heartbeat_message(kind, 8, 0, 0, 4, 3)


def texts(received: list[Received]) -> list[str]:
    return [item.message.text for item in received if item.message.get_type() == "STATUSTEXT"]


def test_everything_is_sent_unprompted_and_nothing_else(bench: Bench) -> None:
    sent: Counter[tuple[str, int]] = Counter()
    for _ in range(10):  # in pieces, so that no socket buffer overflows
        bench.run(25)
        sent.update((item.message.get_type(), item.component) for item in bench.gcs.take())
    assert sent["HEARTBEAT", AUTOPILOT] == 1
    assert sent["HEARTBEAT", CAMERA] == 1
    assert sent["HEARTBEAT", REFEREE] == 1
    assert sent["MISSION_CURRENT", AUTOPILOT] == 1
    assert sent["MISSION_CURRENT", REFEREE] == 1
    assert sent["ATTITUDE", AUTOPILOT] == 50
    assert not {"STATUSTEXT", "COMMAND_ACK", "PARAM_VALUE"} & {name for name, _ in sent}


def test_texts_go_only_where_a_ground_station_was_heard(bench: Bench) -> None:
    bench.gcs.send(heartbeat(GCS))
    bench.api.send(heartbeat(ONBOARD), system=1, component=191)
    bench.handle()
    bench.vehicle.autopilot.texts = [StatusText(severity=6, text="Ready for takeoff!")]
    bench.run(1)
    assert texts(bench.gcs.take()) == ["Ready for takeoff!\t"]
    assert texts(bench.api.take()) == []


def test_the_referee_speaks_on_every_link(bench: Bench) -> None:
    bench.vehicle.events = [CourseEvent(kind=CourseEventKind.PASSED, gate=0, text="Passed gate 1")]
    bench.run(1)
    for client in (bench.gcs, bench.api):
        assert texts(client.take()) == ["Passed gate 1"]


def test_a_command_is_answered_on_its_own_link_only(bench: Bench) -> None:
    bench.api.send(mavlink.MAVLink_command_long_message(1, 1, 400, 0, 1, *[0.0] * 6))
    bench.handle()
    assert [item.message.get_type() for item in bench.api.take()] == ["COMMAND_ACK"]
    assert bench.gcs.take() == []


def test_each_component_answers_commands_in_its_own_name(bench: Bench) -> None:
    for component, message_id in ((CAMERA, 269), (REFEREE, 42), (AUTOPILOT, 148)):
        command = mavlink.MAVLink_command_long_message(1, component, 512, 0, message_id, *[0.0] * 6)
        bench.gcs.send(command)
        bench.handle()
        answers = bench.gcs.take()
        assert [item.component for item in answers] == [component, component]
        assert answers[1].message.result == 0


def test_a_time_that_is_asked_for_has_its_epoch(bench: Bench) -> None:
    bench.gcs.send(mavlink.MAVLink_command_long_message(1, 1, 512, 0, 2, 0, 0, 0, 0, 0, 0))
    bench.handle()
    (told,) = [got.message for got in bench.gcs.take() if got.message.get_msgId() == 2]
    assert told.time_unix_usec == EPOCH_US + bench.vehicle.time_us


def test_a_refused_setpoint_is_told_at_once_and_reaches_nobody(bench: Bench) -> None:
    bench.gcs.send(heartbeat(GCS))
    bench.gcs.send(
        mavlink.MAVLink_set_position_target_local_ned_message(9, 1, 1, 12, 1479, *[0.0] * 11)
    )
    bench.handle()
    expected = "SET_POSITION_TARGET_LOCAL_NED coordinate frame 12 unsupported\t"
    assert texts(bench.gcs.take()) == [expected[:50], expected[50:]]
    assert bench.vehicle.autopilot.setpoints == []


@pytest.mark.parametrize(
    ("target", "taken"),
    [((1, 1), True), ((0, 0), True), ((1, 0), True), ((2, 1), False), ((1, 100), False)],
)
def test_setpoints_are_taken_by_their_target(
    bench: Bench,
    target: tuple[int, int],
    taken: bool,  # noqa: FBT001
) -> None:
    bench.vehicle.time_us = 40_000
    bench.api.send(
        mavlink.MAVLink_set_position_target_local_ned_message(40, *target, 8, 1479, *[0.0] * 11)
    )
    bench.handle()
    assert len(bench.vehicle.autopilot.setpoints) == int(taken)
    assert bench.endpoint.take_answer() == (40_000 if taken else -1)


def test_a_parameter_change_is_echoed_on_both_links(bench: Bench) -> None:
    bench.gcs.send(mavlink.MAVLink_param_set_message(1, 1, b"MPC_XY_VEL_MAX", 8.0, 9))
    bench.handle()
    for client in (bench.gcs, bench.api):
        (echo,) = client.take()
        assert (echo.message.param_id, echo.message.param_value) == ("MPC_XY_VEL_MAX", 8.0)


def test_another_systems_parameters_are_none_of_ours(bench: Bench) -> None:
    bench.gcs.send(mavlink.MAVLink_param_request_list_message(2, 1))
    bench.handle()
    bench.endpoint.advance_lists(TICK_US)
    assert bench.gcs.take() == []


def test_parameters_are_listed_while_vehicle_time_stands(bench: Bench) -> None:
    bench.gcs.send(mavlink.MAVLink_param_request_list_message(1, 1))
    bench.handle()
    for _ in range(10):
        bench.endpoint.advance_lists(TICK_US)
    assert not bench.endpoint.is_listing
    assert [item.message.param_index for item in bench.gcs.take()] == [65535, 0, 1, 2]


def test_what_addresses_nobody_is_forwarded_unchanged(bench: Bench) -> None:
    raw = bench.api.send(mavlink.MAVLink_named_value_float_message(1, b"unc_epis", 0.5), 1, 191)
    bench.handle()
    (received,) = bench.gcs.take()
    assert received.raw == raw
    assert bench.api.take() == []


def test_what_addresses_a_component_goes_where_it_was_seen(bench: Bench) -> None:
    bench.api.send(heartbeat(ONBOARD), system=1, component=191)
    bench.handle()
    bench.gcs.take()
    for target in ((1, 191), (1, 192), (9, 1), (1, 1)):
        bench.gcs.send(mavlink.MAVLink_command_long_message(*target, 31999, 0, *[0.0] * 7))
    bench.handle()
    forwarded = [item for item in bench.api.take() if item.message.get_type() == "COMMAND_LONG"]
    assert [item.message.target_component for item in forwarded] == [191]


def test_nobody_speaks_in_the_vehicles_name(bench: Bench) -> None:
    bench.api.send(heartbeat(2), system=1, component=1)
    bench.handle()
    assert bench.gcs.take() == []


def test_a_trigger_goes_to_both_links_in_the_cameras_name(bench: Bench) -> None:
    bench.endpoint.publish_trigger(ImageStamp(52_000, 1))
    for client in (bench.gcs, bench.api):
        (trigger,) = client.take()
        message = trigger.message
        assert (trigger.component, message.time_usec, message.seq) == (CAMERA, 52_000, 1)


def test_a_lost_ground_station_is_told_of_in_vehicle_time(bench: Bench) -> None:
    bench.gcs.send(heartbeat(GCS))
    bench.handle()
    said: list[str] = []
    for _ in range(12 * 10):
        bench.run(25)
        said += texts(bench.gcs.take())
    assert said == ["Connection to ground station lost\t"]
    bench.gcs.send(heartbeat(GCS))
    bench.handle()
    assert texts(bench.gcs.take()) == ["GCS connection regained\t"]


def answers_both(bench: Bench) -> bool:
    """Whether a valid ping and a valid command are answered on both links, and once."""
    ping = mavlink.MAVLink_ping_message(0, PING, 0, 0)
    command = mavlink.MAVLink_command_long_message(1, 1, 512, 0, 148, *[0.0] * 6)
    for client in (bench.gcs, bench.api):
        client.take()
        for message in (ping, command):
            client.send(message, *ASKER)
    bench.handle()
    answers = [
        Counter(item.message.get_type() for item in client.take() if is_answer(item.message))
        for client in (bench.gcs, bench.api)
    ]
    return answers == [ANSWERS, ANSWERS]


def is_answer(message: Any) -> bool:
    if message.get_type() == "PING":
        return bool(message.seq == PING and message.target_system == ASKER[0])
    if message.get_type() == "COMMAND_ACK":
        return bool((message.command, message.result, message.target_system) == (512, 0, ASKER[0]))
    return bool(message.get_type() == "AUTOPILOT_VERSION")


@settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=300, deadline=None
)
@given(st.sampled_from(ANY), st.binary(min_size=1, max_size=255))
def test_no_message_of_any_content_raises(bench: Bench, message_id: int, payload: bytes) -> None:
    packed = Packed(message_id, payload, mavlink.mavlink_map[message_id].crc_extra)
    for system, component in ((255, 190), (1, 191), (1, 1)):
        raw = wrap(packed, sequence=0, system=system, component=component)
        bench.gcs.send_raw(raw)
        bench.handle()
    bench.endpoint.publish()
    assert answers_both(bench)


@settings(
    suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=300, deadline=None
)
@given(
    st.sampled_from(["command_long", "command_int"]),
    st.sampled_from([16, 20, 21, 22, 176, 192, 246, 400, 510, 511, 512, 519, 520, 521, 31999]),
    st.lists(st.floats(width=32), min_size=5, max_size=7),
    st.sampled_from([0, 1, 25, 100]),
)
def test_no_command_of_any_numbers_raises(
    bench: Bench, kind: str, command: int, params: list[float], component: int
) -> None:
    values = (params + [0.0] * 7)[:7]
    if kind == "command_long":
        message = mavlink.MAVLink_command_long_message(1, component, command, 0, *values)
    else:
        message = mavlink.MAVLink_command_int_message(
            1, component, 5, command, 0, 0, *values[:4], -(2**31), 2**31 - 1, values[4]
        )
    bench.api.send(message)
    bench.handle()
    bench.run(3)
    assert answers_both(bench)
