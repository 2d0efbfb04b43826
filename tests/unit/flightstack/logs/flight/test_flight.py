"""What a flight is said to have been: from a made flight whose facts are known."""

import json

import numpy as np
import pytest
from pymavlink.dialects.v20 import all as mavlink

from flightstack.logs import read, read_bytes
from flightstack.logs.checks import run_checks
from flightstack.logs.facts.summary import summarise
from flightstack.logs.flight.flight import Flight
from flightstack.logs.flight.modes import mode_name
from flightstack.logs.flight.parameters import read_parameters
from flightstack.logs.flight.tracking import response_lag_s
from flightstack.logs.text.summary_text import duration, one_line, page
from tests.paths import GOLDEN
from tests.unit.flightstack.logs.made_flights import LAG_S, PX4_OFFBOARD, make_flight
from tests.unit.flightstack.logs.made_logs import START_US, record, tlog


@pytest.fixture(scope="module")
def flight() -> Flight:
    return Flight(read_bytes(make_flight(20.0)))


def test_modes_and_arming_stand_where_they_were(flight: Flight) -> None:
    modes: list[tuple[str, object]] = [
        (span.label, flight.seconds(span.start_us)) for span in flight.modes
    ]
    assert modes == [
        ("AUTO.LOITER", pytest.approx(0, abs=0.01)),
        ("AUTO.TAKEOFF", pytest.approx(2, abs=0.01)),
        ("OFFBOARD", pytest.approx(8, abs=0.01)),
        ("AUTO.LAND", pytest.approx(28, abs=0.01)),
    ]
    (armed,) = flight.armed
    assert flight.seconds(armed.start_us) == pytest.approx(2, abs=0.01)
    assert armed.duration_s == pytest.approx(31, abs=0.01)
    assert flight.ending == "landed and disarmed"


def test_images_setpoints_and_their_latency_are_matched(flight: Flight) -> None:
    assert flight.answers.images == flight.answers.answered == 400
    assert np.allclose(flight.answers.latency_ms, 4.0)


def test_a_skipped_image_is_counted_as_unanswered() -> None:
    flight = Flight(read_bytes(make_flight(5.0, skip=4)))
    assert 0 < flight.answers.answered < flight.answers.images


def test_the_lag_of_the_response_is_found(flight: Flight) -> None:
    for axis in range(3):
        lag = response_lag_s(flight.tracking, axis)
        assert lag == pytest.approx(LAG_S, abs=0.06)
    assert response_lag_s(flight.tracking, 3) is None  # the yaw rate never changed


def test_decisions_and_members_are_read(flight: Flight) -> None:
    decisions = flight.decisions
    assert len(decisions) == 400
    assert decisions.aleatoric_std.shape == (400, 4)
    assert set(decisions.member[:, 0].tolist()) == {0, 1, 2, 3, 4}
    assert flight.members.mean.shape == (400, 5, 4)
    assert np.array_equal(flight.members.stamp_us, decisions.stamp_us)
    assert np.allclose(decisions.command, flight.tracking.setpoint, atol=1e-6)


def test_gates_and_course_are_told(flight: Flight) -> None:
    assert [gate.index for gate in flight.gates] == list(range(8))
    assert flight.gates[0].centre_ned == pytest.approx((0, 0, -3))
    assert flight.gates_passed == 5
    assert [event.kind for event in flight.course_events] == ["passed"] * 5 + ["missed"]


def test_distance_is_the_way_flown() -> None:
    flight = Flight(read_bytes(make_flight(20.0)))
    steps = np.diff(flight.motion.position_ned, axis=0)
    assert flight.motion.distance_m() == pytest.approx(
        float(np.linalg.norm(steps, axis=1).sum()), rel=0.02
    )


def test_the_summary_is_plain_json_and_one_page(flight: Flight) -> None:
    facts = summarise(flight, run_checks(flight))
    again = json.loads(json.dumps(facts, allow_nan=False))
    assert again["course"] == {
        "gates_passed": 5,
        "ended": "missed",
        "text": "Missed gate 6: passed outside",
    }
    assert again["offboard"]["rate_hz"] == pytest.approx(20.0)
    assert [link["lost"] for link in again["links"]] == [0, 0, 0, 0]
    text = page(facts)
    for expected in ("5 gates passed", "mode OFFBOARD", "400 of 400 answered", "link_loss"):
        assert expected in text
    assert "\n" not in one_line(facts)


def test_a_log_cut_in_the_air_says_so() -> None:
    whole = make_flight(20.0)
    flight = Flight(read_bytes(whole[: len(whole) // 2]))
    assert flight.ending == "in the air, armed"
    assert flight.log.damage.is_cut
    levels = {finding.name: finding.level.value for finding in run_checks(flight)}
    assert levels["ending"] == levels["file_damage"] == "warning"


def test_a_log_without_an_autopilot_has_a_summary_too() -> None:
    beat = mavlink.MAVLink_heartbeat_message(6, 8, 0, 0, 4, 3)
    flight = Flight(read_bytes(tlog([beat] * 5)))
    facts = summarise(flight, run_checks(flight))
    assert facts["vehicle"] is None
    assert facts["ends"] == "unknown: no heartbeat of an autopilot"
    assert page(facts)


def test_a_flight_of_ours_reads_as_it_was() -> None:
    flight = Flight(read(GOLDEN))
    facts = summarise(flight, run_checks(flight))
    assert facts["vehicle"]["kind"] == "px4 quadrotor"
    assert facts["course"]["ended"] == "missed"
    assert [link["lost"] for link in facts["links"]] == [0, 0, 0, 0]
    assert facts["offboard"]["frames"] == facts["offboard"]["frames_answered"] > 50
    assert facts["damage"]["lost_bytes"] == 0


def test_another_vehicle_can_be_chosen() -> None:
    one = mavlink.MAVLink_heartbeat_message(2, 12, 1, PX4_OFFBOARD, 4, 3)
    data = tlog([one] * 9) + tlog([one] * 3, system=7)
    assert Flight(read_bytes(data)).vehicle is not None
    chosen = Flight(read_bytes(data), system=7).vehicle
    assert chosen is not None
    assert chosen.system == 7


@pytest.mark.parametrize(
    ("autopilot", "kind", "base", "custom", "name"),
    [
        (12, 2, 209, 0x00060000, "OFFBOARD"),
        (12, 2, 157, 0x05040000, "AUTO.RTL"),
        (12, 2, 209, 0x00030000, "POSCTL"),
        (12, 2, 1, 0x00FF0000, "0x00ff0000"),
        (3, 2, 81, 4, "GUIDED"),
        (3, 1, 81, 11, "RTL"),
        (3, 10, 81, 10, "AUTO"),
        (0, 2, 64, 3, "base 64 custom 3"),
    ],
)
def test_modes_are_named(autopilot: int, kind: int, base: int, custom: int, name: str) -> None:
    assert mode_name(autopilot, kind, base, custom) == name


def test_chunked_and_copied_texts_are_put_together() -> None:
    def text(piece: bytes, text_id: int, chunk: int) -> bytes:
        sender = mavlink.MAVLink(None, 1, 1)
        return bytes(mavlink.MAVLink_statustext_message(6, piece, text_id, chunk).pack(sender))

    pieces = [(b"x" * 50, 1, 0), (b"x" * 50, 9, 0), (b"yz\t", 1, 1), (b"yz\t", 9, 1)]
    data = b"".join(record(START_US + i, text(*piece)) for i, piece in enumerate(pieces))
    assert [t.text for t in Flight(read_bytes(data)).texts] == ["x" * 50 + "yz"]


def test_parameters_and_changes_are_read() -> None:
    def value(name: bytes, number: float, kind: int) -> bytes:
        sender = mavlink.MAVLink(None, 1, 1)
        message = mavlink.MAVLink_param_value_message(name, number, kind, 2, 0)
        return bytes(message.pack(sender))

    as_float = float(np.array([7], dtype="<i4").view("<f4")[0])
    beat = mavlink.MAVLink_heartbeat_message(2, 12, 1, 0, 3, 3).pack(mavlink.MAVLink(None, 1, 1))
    packets = [
        beat,
        value(b"MPC_XY_P", 0.95, 9),
        value(b"COM_RCL_EXCEPT", as_float, 6),
        value(b"MPC_XY_P", 1.1, 9),
    ]
    data = b"".join(record(START_US + i * 1000, raw) for i, raw in enumerate(packets))
    parameters = read_parameters(Flight(read_bytes(data)))
    assert parameters.values == {"COM_RCL_EXCEPT": 7, "MPC_XY_P": 1.1}
    assert [(c.name, c.before, c.after) for c in parameters.changes] == [("MPC_XY_P", 0.95, 1.1)]


@pytest.mark.parametrize(("seconds", "text"), [(9.53, "9.5 s"), (123.4, "2 min 03 s")])
def test_durations_are_written_for_people(seconds: float, text: str) -> None:
    assert duration(seconds) == text
