"""A camera that lies is held for, said once, and landed for; one that stalls is opened again."""

from pathlib import Path

import numpy as np
import pytest

from flightstack.arrays import Rgb
from flightstack.companion.mission.records import MissionPhase, Outcome
from tests.unit.flightstack.companion.made_flight import (
    FORWARD_M_S,
    SIZE,
    MadeFlight,
    forward_m_s,
)

FAST_M_S, STILL_M_S = 2.0, 0.1
PICTURE = np.random.default_rng(1).integers(0, 256, SIZE, np.uint8)
BLACK, GREY = np.zeros((64, 64, 3), np.uint8), np.full((480, 640, 3), 130, np.uint8)
NOISE = np.random.default_rng(2).normal(40.0, 3.0, (64, 64, 3)).round().astype(np.uint8)
STEP_MS = 50


@pytest.fixture
def flight(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> MadeFlight:
    return MadeFlight(tmp_path, monkeypatch)


def velocities(flight: MadeFlight, for_ms: int, *, image: bool = True) -> list[float]:
    turns = [flight.turn(STEP_MS, image=image) for _ in range(0, for_ms, STEP_MS)]
    return [velocity for sent in turns for velocity in forward_m_s(sent)]


@pytest.mark.parametrize("picture", [PICTURE, BLACK, GREY, NOISE], ids=["same", "0", "grey", "n"])
def test_a_picture_that_cannot_be_is_held_for_then_landed(flight: MadeFlight, picture: Rgb) -> None:
    flight.speed_m_s = FAST_M_S
    velocities(flight, 500)
    flight.picture = picture
    flown = velocities(flight, 2000)
    assert flown == [FORWARD_M_S] * flown.count(FORWARD_M_S) + [0.0] * flown.count(0.0)
    assert flown.count(FORWARD_M_S) * STEP_MS == pytest.approx(1500, abs=2 * STEP_MS)
    flight.speed_m_s = STILL_M_S  # held, it stands
    assert set(velocities(flight, 4000)) == {0.0}
    assert flight.phase() is MissionPhase.FLYING
    velocities(flight, 1000)
    assert flight.phase() is MissionPhase.LANDING
    assert flight.loop.status.outcome is Outcome.CAMERA_LOST
    assert flight.said.getvalue().count("warning: the camera shows") == 1


def test_a_picture_that_moves_again_is_flown_on_by(flight: MadeFlight) -> None:
    flight.speed_m_s = FAST_M_S
    flight.picture = PICTURE
    assert velocities(flight, 3000)[-1] == 0.0
    flight.picture = None
    assert set(velocities(flight, 3000)) == {FORWARD_M_S}


def test_a_vehicle_that_stands_may_see_the_same_for_ever(flight: MadeFlight) -> None:
    flight.speed_m_s = STILL_M_S
    flight.picture = PICTURE
    assert set(velocities(flight, 10_000)) == {FORWARD_M_S}


def test_a_vehicle_that_does_not_say_how_fast_it_is_may_be_moving(flight: MadeFlight) -> None:
    flight.speed_m_s = None
    flight.picture = PICTURE
    assert velocities(flight, 3000)[-1] == 0.0


@pytest.mark.parametrize(("announced_hz", "held"), [(20.0, 0), (8.0, 0), (5.0, 1), (100.0, 1)])
def test_a_rate_that_is_not_the_announced_one_is_held_for(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, announced_hz: float, held: int
) -> None:
    flight = MadeFlight(tmp_path, monkeypatch, announced_hz=announced_hz)
    assert (velocities(flight, 4000)[-1] == 0.0) is bool(held)


def test_a_camera_that_stalls_is_opened_again_while_the_vehicle_holds(flight: MadeFlight) -> None:
    velocities(flight, 500)
    velocities(flight, 1400, image=False)
    assert flight.camera.restarts == 0
    assert velocities(flight, 500, image=False)[-1] == 0.0
    assert flight.camera.restarts == 1
    assert velocities(flight, 500) == [FORWARD_M_S] * 10
    assert flight.phase() is MissionPhase.FLYING


def test_a_camera_is_opened_again_where_the_vehicle_waits_for_its_answer(
    flight: MadeFlight,
) -> None:
    velocities(flight, 500)
    for _ in range(60):
        flight.made.wall.now_s += 0.1
        flight.turn(0, image=False)
    assert flight.camera.restarts == 1
    assert flight.phase() is MissionPhase.FLYING


def test_an_image_that_was_answered_is_no_new_one(flight: MadeFlight) -> None:
    velocities(flight, 500)
    stamp_us, seen = flight.made.clock.stamp_us, flight.pilot.seen
    velocities(flight, 1000, image=False)
    for old_us in (stamp_us, stamp_us - 200_000):
        flight.show(old_us)
        flight.loop._turn()
    assert flight.pilot.seen == seen
    assert flight.loop.status.hold is not None
