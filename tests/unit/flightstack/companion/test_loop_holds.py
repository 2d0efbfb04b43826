"""When the loop sends a velocity of zero, and when it lands, by clocks that the test sets."""

from pathlib import Path

import pytest
from pymavlink.dialects.v20 import common

from flightstack.companion.mission.records import Hold, MissionPhase, Outcome
from tests.unit.flightstack.companion.made_flight import FORWARD_M_S, MadeFlight, forward_m_s


@pytest.fixture
def flight(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> MadeFlight:
    return MadeFlight(tmp_path, monkeypatch)


def commands(flight: MadeFlight) -> list[int]:
    messages = [message for datagram in flight.sent() for message in datagram]
    return [m.command for m in messages if m.get_type() == "COMMAND_LONG"]


def test_each_image_is_answered_by_the_pilot(flight: MadeFlight) -> None:
    assert forward_m_s(flight.turn(50)) == [FORWARD_M_S]
    assert forward_m_s(flight.turn(50)) == [FORWARD_M_S]
    assert flight.pilot.seen == len(flight.loop.latencies_s) == 2


def test_a_camera_that_is_silent_holds_then_lands(flight: MadeFlight) -> None:
    flight.turn(50)
    sent = {ms: forward_m_s(flight.turn(50, image=False)) for ms in range(50, 2501, 50)}
    assert [ms for ms, velocities in sent.items() if velocities] == list(range(500, 2501, 50))
    assert {velocity for velocities in sent.values() for velocity in velocities} == {0.0}
    assert flight.phase() is MissionPhase.FLYING
    assert forward_m_s(flight.turn(50, image=False)) == []
    assert flight.phase() is MissionPhase.LANDING
    assert flight.loop.status.outcome is Outcome.CAMERA_LOST
    assert commands(flight) == [common.MAV_CMD_NAV_LAND]


def test_an_image_ends_the_hold_of_the_camera(flight: MadeFlight) -> None:
    flight.turn(50)
    assert forward_m_s(flight.turn(600, image=False)) == [0.0]
    assert forward_m_s(flight.turn(50)) == [FORWARD_M_S]


def test_whoever_raises_a_hold_stops_the_vehicle_until_it_takes_it_back(
    flight: MadeFlight,
) -> None:
    flight.turn(50)
    flight.loop.holds[Outcome.REFUSED] = Hold(
        reason=Outcome.REFUSED, since_us=50_000, lands_after_us=1_000_000
    )
    assert forward_m_s(flight.turn(50)) == [0.0]
    assert flight.pilot.seen == len(flight.loop.latencies_s) == 1
    del flight.loop.holds[Outcome.REFUSED]
    assert forward_m_s(flight.turn(50)) == [FORWARD_M_S]


def test_a_hold_that_lasts_lands_for_its_reason(flight: MadeFlight) -> None:
    flight.loop.holds[Outcome.REFUSED] = Hold(
        reason=Outcome.REFUSED, since_us=0, lands_after_us=100_000
    )
    flight.turn(50)
    flight.turn(50)
    assert flight.phase() is MissionPhase.FLYING
    flight.turn(50)
    assert flight.phase() is MissionPhase.LANDING
    assert flight.loop.status.outcome is Outcome.REFUSED


def test_a_silent_vehicle_is_told_to_land_until_it_is_heard(flight: MadeFlight) -> None:
    flight.turn(50)
    flight.silence(3.0)
    assert flight.phase() is MissionPhase.FLYING
    flight.silence(0.1)
    assert flight.phase() is MissionPhase.REACHING
    assert flight.loop.status.outcome is Outcome.LINK_LOST
    assert commands(flight) == [common.MAV_CMD_NAV_LAND]
    for _ in range(30):
        flight.silence(0.5)
    assert flight.phase() is MissionPhase.REACHING
    assert set(commands(flight)) == {common.MAV_CMD_NAV_LAND}
    assert len(commands(flight)) > 10
    flight.turn(18_150)  # heard again, where the wall has it
    assert flight.phase() is MissionPhase.LANDING


def test_without_images_a_vehicle_that_is_heard_again_lands_too(flight: MadeFlight) -> None:
    flight.turn(50)
    flight.silence(4.0)
    assert flight.phase() is MissionPhase.REACHING
    for _ in range(20):
        flight.turn(50, image=False)
    assert flight.phase() is MissionPhase.LANDING


def test_an_error_of_our_own_holds_and_lands(flight: MadeFlight) -> None:
    flight.turn(50)
    flight.loop._steering.stumble(RuntimeError("on purpose"), 50_000)
    assert "please report it: RuntimeError('on purpose')" in flight.said.getvalue()
    assert forward_m_s(flight.turn(50)) == [0.0]
    for _ in range(21):
        flight.turn(50)
    assert flight.phase() is MissionPhase.LANDING
    assert flight.loop.status.outcome is Outcome.COMPANION_FAILED


def test_an_error_at_every_turn_is_given_up(flight: MadeFlight) -> None:
    flight.camera.take = None  # type: ignore[method-assign, assignment]
    with pytest.raises(TypeError):
        flight.loop.run()
    assert commands(flight) == [common.MAV_CMD_NAV_LAND]


@pytest.mark.parametrize("flown_ms", [3_000, 19_000])
def test_a_vehicle_that_restarts_in_flight_is_said_to(flight: MadeFlight, flown_ms: int) -> None:
    flight.turn(50)
    flight.turn(flown_ms)
    flight.turn(-flown_ms, image=False)  # one stamp alone could be an error
    flight.turn(-flown_ms, image=False)
    assert flight.loop.status.outcome is Outcome.RESTARTED
    assert flight.loop.status.ended_us == 1000 * (flown_ms + 50)


def test_a_vehicle_that_stands_still_hears_its_answer_again(flight: MadeFlight) -> None:
    flight.turn(50)
    assert forward_m_s(flight.turn(0, image=False)) == []
    flight.made.wall.now_s += 1.0
    assert forward_m_s(flight.turn(0, image=False)) == [FORWARD_M_S]
