"""The map of gates: what it keeps, what it forgets, and that nonsense leaves it sound."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from flightstack.belief.mapping import observe, predict, sighting_of
from flightstack.belief.records import NO_TRACKS, GateTracks
from flightstack.belief.settings import MapSettings
from flightstack.records import GateDetections, Pose
from tests.unit.flightstack.belief.made_gates import Point, pose_at, seen

SETTINGS = MapSettings()
GATE: tuple[Point, float] = ((6.0, 0.5, -3.2), 0.3)
TWIN: tuple[Point, float] = ((5.3, 2.8, -3.2), 0.3)


def look(
    tracks: GateTracks, detections: GateDetections, pose: Pose, numbers: int = 0
) -> tuple[GateTracks, int]:
    before = predict(tracks, 0.05, SETTINGS)
    return observe(before, sighting_of(detections, pose, SETTINGS), pose, SETTINGS, numbers)


def look_often(gates: list[tuple[Point, float]], times: int = 20) -> GateTracks:
    tracks, numbers, pose = NO_TRACKS, 0, pose_at()
    for _ in range(times):
        tracks, numbers = look(tracks, seen(gates, pose), pose, numbers)
    return tracks


@pytest.mark.parametrize("yaw_rad", [-0.4, 0.0, 0.5])
def test_a_gate_is_where_it_was_seen_whatever_the_attitude(yaw_rad: float) -> None:
    pose = pose_at((1.0, -0.5, -2.5), yaw_rad)
    tracks, _ = look(NO_TRACKS, seen([GATE], pose), pose)
    assert tracks.position_ned[0] == pytest.approx(GATE[0], abs=1e-6)
    assert np.cos(2 * (tracks.heading_rad[0] - GATE[1])) == pytest.approx(1.0)


def test_looking_makes_surer_though_never_surer_than_errors_that_last() -> None:
    once, often = look_often([GATE], 1), look_often([GATE], 40)
    assert np.trace(often.covariance[0, :3, :3]) < np.trace(once.covariance[0, :3, :3])
    assert often.log_odds[0] > once.log_odds[0]
    assert float(often.log_odds[0]) <= SETTINGS.max_log_odds


def test_two_gates_side_by_side_stay_two() -> None:
    tracks = look_often([GATE, TWIN])
    assert len(tracks) == 2
    assert sorted(tracks.number.tolist()) == [0, 1]
    assert tracks.position_ned == pytest.approx(np.array([GATE[0], TWIN[0]]), abs=1e-6)


def test_what_is_not_seen_again_where_it_should_be_is_forgotten() -> None:
    tracks, numbers, pose = look_often([GATE], 2), 1, pose_at()
    for _ in range(20):
        tracks, numbers = look(tracks, seen([], pose), pose, numbers)
    assert len(tracks) == 0


def test_what_is_out_of_view_is_remembered() -> None:
    tracks, pose = look_often([GATE]), pose_at(yaw_rad=3.1)
    for _ in range(100):
        tracks, _ = look(tracks, seen([], pose), pose, 1)
    assert tracks.number.tolist() == [0]
    assert np.sqrt(tracks.covariance[0, :3, :3].max()) <= SETTINGS.max_position_std_m + 1e-9


def test_time_alone_makes_unsure() -> None:
    tracks = look_often([GATE])
    later = predict(tracks, 2.0, SETTINGS)
    assert np.trace(later.covariance[0, :3, :3]) > np.trace(tracks.covariance[0, :3, :3])
    assert predict(tracks, -1.0, SETTINGS) is tracks


def test_a_gate_right_before_the_camera_moves_nothing() -> None:
    tracks, pose = look_often([GATE]), pose_at((5.6, 0.5, -3.2))
    nonsense = ((6.1, 0.7, -3.2), 0.3)
    again, _ = look(tracks, seen([nonsense], pose), pose, 1)
    assert again.position_ned[0] == pytest.approx(GATE[0], abs=1e-6)


@settings(max_examples=6, deadline=None)
@given(st.integers(0, 2**31))
def test_hundreds_of_false_gates_leave_a_bounded_map_with_sound_covariances(seed: int) -> None:
    rng = np.random.default_rng(seed)
    tracks, numbers, pose = look_often([GATE]), 1, pose_at()
    for _ in range(3):
        ahead = rng.uniform(0.3, 20.0, 300)
        gates: list[tuple[Point, float]] = [
            ((float(x), float(x * y), float(x * z)), float(h))
            for x, y, z, h in zip(ahead, *rng.uniform(-1.0, 1.0, (2, 300)),
                                  rng.uniform(-1.5, 1.5, 300), strict=True)
        ]  # fmt: skip
        detections = seen(gates, pose, score=float(rng.uniform(0.0, 1.0)))
        tracks, numbers = look(tracks, detections, pose, numbers)
    assert len(tracks) <= SETTINGS.max_tracks
    assert np.isfinite(tracks.mean).all()
    for covariance in tracks.covariance:
        assert np.linalg.eigvalsh(covariance).min() > -1e-9
        assert covariance == pytest.approx(covariance.T)
