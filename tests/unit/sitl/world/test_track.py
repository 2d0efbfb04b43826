import math

import pytest

from sitl.errors import UsageError
from sitl.world.track import GATE_HEIGHT_M, RADIUS_M, START_DISTANCE_M, make_track


def horizontal_distance(a: tuple[float, float, float], b: tuple[float, float, float]) -> float:
    return math.hypot(a[0] - b[0], a[1] - b[1])


def test_noise_free_gates_stand_on_the_circle_45_degrees_apart() -> None:
    track = make_track(7)
    for gate in track.gates:
        assert horizontal_distance(gate.centre_ned, track.centre_ned) == pytest.approx(RADIUS_M)
        assert gate.centre_ned[2] == pytest.approx(-GATE_HEIGHT_M)
    chord = 2 * RADIUS_M * math.sin(math.pi / 8)
    for gate, following in zip(track.gates, track.gates[1:], strict=False):
        assert horizontal_distance(gate.centre_ned, following.centre_ned) == pytest.approx(chord)


def test_the_spawn_faces_the_nominal_first_gate() -> None:
    first = make_track(0).gates[0]
    assert first.centre_ned[0] == pytest.approx(START_DISTANCE_M)
    assert first.centre_ned[1] == pytest.approx(0.0)


def test_a_clockwise_track_turns_right_and_the_other_is_its_mirror() -> None:
    clockwise = make_track(3, radius_noise_m=1.0, height_noise_m=2.0)
    mirrored = make_track(3, radius_noise_m=1.0, height_noise_m=2.0, direction="ccw")
    assert clockwise.gates[1].yaw_rad - clockwise.gates[0].yaw_rad == pytest.approx(math.pi / 4)
    for gate, twin in zip(clockwise.gates, mirrored.gates, strict=True):
        north, east, down = gate.centre_ned
        assert twin.centre_ned == pytest.approx((north, -east, down))
        assert twin.yaw_rad == pytest.approx(-gate.yaw_rad)


def test_noise_moves_the_radius_both_ways_and_the_height_up_only() -> None:
    radii, heights = [], []
    for seed in range(50):
        track = make_track(seed, radius_noise_m=1.5, height_noise_m=3.0)
        radii += [horizontal_distance(g.centre_ned, track.centre_ned) for g in track.gates]
        heights += [-g.centre_ned[2] for g in track.gates]
    assert RADIUS_M - 1.5 <= min(radii) < RADIUS_M - 1.4
    assert RADIUS_M + 1.4 < max(radii) <= RADIUS_M + 1.5
    assert GATE_HEIGHT_M <= min(heights) < GATE_HEIGHT_M + 0.1
    assert GATE_HEIGHT_M + 2.9 < max(heights) <= GATE_HEIGHT_M + 3.0


def test_a_seed_names_one_track() -> None:
    assert make_track(5, radius_noise_m=1.0) == make_track(5, radius_noise_m=1.0)
    assert make_track(5, radius_noise_m=1.0) != make_track(6, radius_noise_m=1.0)


@pytest.mark.parametrize("noise", [-0.1, 99.0, math.nan])
def test_impossible_noise_is_refused_by_name(noise: float) -> None:
    with pytest.raises(UsageError, match="GRN"):
        make_track(0, radius_noise_m=noise)
    with pytest.raises(UsageError, match="GHN"):
        make_track(0, height_noise_m=noise)
