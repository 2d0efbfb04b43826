import math
from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray

from sitl.frames import quaternion_from_euler
from sitl.records.course import Gate
from sitl.records.gate import GATE_INNER_M, GATE_OUTER_M
from sitl.sensors.camera.camera import SIZE_PX, Camera
from sitl.sensors.camera.look import draw_look, make_texture

LEVEL = quaternion_from_euler(0.0, 0.0, 0.0)
EYE = (0.0, 0.0, -3.0)


def gate_at(north: float, east: float = 0.0, height: float = 3.0, yaw: float = 0.0) -> Gate:
    return Gate(index=0, centre_ned=(north, east, -height), yaw_rad=yaw)


@pytest.fixture
def camera() -> Iterator[Camera]:
    camera = Camera((gate_at(4.0),), draw_look(np.random.default_rng(2)))
    yield camera
    camera.close()


def changed_pixels(
    camera: Camera, gate: Gate, q: tuple[float, float, float, float] = LEVEL
) -> NDArray[np.bool]:
    camera.place_gates((gate,))
    with_gate = camera.render(EYE, q).astype(int)
    camera.place_gates((gate_at(-500.0),))
    without = camera.render(EYE, q).astype(int)
    seen: NDArray[np.bool] = np.abs(with_gate - without).sum(axis=2) > 30
    return seen


def test_a_gate_has_its_size_at_its_distance(camera: Camera) -> None:
    mask = changed_pixels(camera, gate_at(4.0))
    columns = np.flatnonzero(mask.any(axis=0))
    outer_px = columns[-1] - columns[0] + 1
    face_m = 4.0 - 0.075  # the face towards the camera
    assert outer_px == pytest.approx(GATE_OUTER_M / face_m * SIZE_PX / 2, abs=1.5)
    middle = mask[SIZE_PX // 2]
    assert not middle[SIZE_PX // 2 - 3 : SIZE_PX // 2 + 3].any()  # one sees through it
    inner_px = np.diff(np.flatnonzero(middle)).max() - 1
    assert inner_px == pytest.approx(GATE_INNER_M / face_m * SIZE_PX / 2, abs=2.0)


@pytest.mark.parametrize(
    ("gate", "side"),
    [
        (gate_at(4.0, east=2.0), "right"),
        (gate_at(4.0, east=-2.0), "left"),
        (gate_at(4.0, height=5.0), "top"),
        (gate_at(4.0, height=1.5), "bottom"),
    ],
)
def test_a_gate_appears_on_its_side(camera: Camera, gate: Gate, side: str) -> None:
    rows, columns = np.nonzero(changed_pixels(camera, gate))
    where = {"right": columns.mean() > 36, "left": columns.mean() < 27}
    where |= {"top": rows.mean() < 27, "bottom": rows.mean() > 36}
    assert where[side]


def test_the_camera_turns_and_tilts_with_the_body(camera: Camera) -> None:
    ahead = gate_at(4.0)
    turned_right = changed_pixels(camera, ahead, quaternion_from_euler(0.0, 0.0, 0.3))
    assert np.nonzero(turned_right)[1].mean() < 27  # the scene moves left
    nose_up = changed_pixels(camera, ahead, quaternion_from_euler(0.0, 0.3, 0.0))
    assert np.nonzero(nose_up)[0].mean() > 36  # the scene moves down
    right_wing_down = changed_pixels(
        camera, gate_at(4.0, 2.0), quaternion_from_euler(0.3, 0.0, 0.0)
    )
    assert np.nonzero(right_wing_down)[0].mean() < 27  # what is right moves up


def test_ground_and_sky_meet_at_the_horizon(camera: Camera) -> None:
    camera.place_gates((gate_at(-500.0),))
    image = camera.render(EYE, LEVEL).astype(float)
    look = camera.look
    sky, ground = image[:28].mean(axis=(0, 1)), image[40:].mean(axis=(0, 1))
    expected = (np.array(look.ground_light) + np.array(look.ground_dark)) / 2 * 255
    assert np.abs(ground - expected).max() < 40
    assert np.abs(sky - ground).max() > 20


def test_the_same_pose_gives_the_same_bytes(camera: Camera) -> None:
    other = Camera((gate_at(4.0),), camera.look)
    try:
        assert np.array_equal(camera.render(EYE, LEVEL), other.render(EYE, LEVEL))
    finally:
        other.close()


def test_textures_tile_and_differ() -> None:
    texture = make_texture(0)
    seam = np.abs(texture[:, 0] - texture[:, -1]).mean()
    inside = np.abs(np.diff(texture, axis=1)).mean()
    assert seam < 1.5 * inside
    assert not np.array_equal(texture, make_texture(1))


def test_looks_differ_by_seed_and_stay_in_range() -> None:
    looks = [draw_look(np.random.default_rng(seed)) for seed in range(50)]
    assert len({look.gate_colour for look in looks}) == 50
    for look in looks:
        for colour in (look.gate_colour, look.sky_zenith, look.ground_light):
            assert all(0.0 <= channel <= 1.0 for channel in colour)
        assert math.isclose(sum(part**2 for part in look.light_nwu), 1.0, rel_tol=1e-6)
