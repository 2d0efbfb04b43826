"""Gates of other shapes: what is open, what is touched, what is seen."""

import math
from collections.abc import Iterator
from contextlib import closing
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from sitl.errors import UsageError
from sitl.records.course import CourseState, Gate
from sitl.records.gate import STANDARD_SHAPE, GateShape
from sitl.records.scenery import PLAIN, Scenery
from sitl.sensors.camera.camera import SIZE_PX, Camera
from sitl.sensors.camera.look import draw_look
from sitl.world.airframe import load_airframe
from sitl.world.referee import Referee
from sitl.world.world import World

LEVEL = (1.0, 0.0, 0.0, 0.0)
EYE = (0.0, 0.0, -3.0)
ROUND = GateShape(outline="circle", inner_m=1.6, outer_m=2.2)
CORNER_M = 0.6  # right and down: in a square of 1.6 m, out of a circle


def gate(shape: GateShape, north: float = 4.0) -> Gate:
    return Gate(index=0, centre_ned=(north, 0.0, -3.0), yaw_rad=0.0, shape=shape)


def seen(scenery: Scenery, seed: int = 2, north: float = 4.0) -> NDArray[np.uint8]:
    look = draw_look(np.random.default_rng(seed), scenery)
    gates = (gate(scenery.gate, north),)
    camera = Camera(gates, look, field_of_view_deg=scenery.field_of_view_deg)
    with closing(camera):
        return camera.render(EYE, LEVEL)


def width_px(scenery: Scenery) -> int:
    there, away = (seen(scenery, north=north).astype(int) for north in (4.0, -500.0))
    columns = np.flatnonzero((np.abs(there - away).sum(axis=2) > 30).any(axis=0))
    return int(columns[-1] - columns[0] + 1)


@pytest.mark.parametrize(
    ("shape", "state"),
    [
        (GateShape(inner_m=1.6, outer_m=2.2), CourseState.FINISHED),
        (ROUND, CourseState.FAILED),
        (STANDARD_SHAPE, CourseState.FAILED),
    ],
)
def test_the_referee_judges_by_the_shape_of_the_opening(
    shape: GateShape, state: CourseState
) -> None:
    referee = Referee((gate(shape),), laps=1)
    before, after = ((north, CORNER_M, CORNER_M - 3.0) for north in (3.9, 4.1))
    referee.update(before, after, contact=False)
    assert referee.status.state is state


@pytest.fixture
def round_world() -> Iterator[World]:
    world = World((gate(ROUND),), load_airframe("x500"), tick_s=0.004)
    yield world
    world.close()


@pytest.mark.parametrize("angle_deg", range(0, 360, 40))
def test_a_ring_can_be_touched_all_around_and_flown_through(
    round_world: World, angle_deg: int
) -> None:
    right, down = math.sin(math.radians(angle_deg)), -math.cos(math.radians(angle_deg))
    assert round_world.touches_gate_at((4.0, 0.95 * right, 0.95 * down - 3.0), LEVEL)
    assert not round_world.touches_gate_at((4.0, 0.4 * right, 0.4 * down - 3.0), LEVEL)
    assert not round_world.touches_gate_at((4.0, 1.6 * right, 1.6 * down - 3.0), LEVEL)


def test_gates_are_seen_in_their_size_and_by_the_cameras_field_of_view() -> None:
    assert width_px(Scenery(gate=ROUND)) == pytest.approx(2.2 / 4.0 * SIZE_PX / 2, abs=1.5)
    wide = Scenery(field_of_view_deg=120.0)
    expected = 1.6 / 4.0 * SIZE_PX / 2 / math.tan(math.radians(60.0))
    assert width_px(wide) == pytest.approx(expected, abs=1.5)


def test_a_ring_is_round_where_a_square_has_corners() -> None:
    corner = (slice(20, 24), slice(20, 24))  # of the frame of 2.2 m at 4 m: 23 to 41 px
    away = seen(PLAIN, north=-500.0)[corner].astype(int)
    square = Scenery(gate=GateShape(inner_m=1.6, outer_m=2.4))
    ring = Scenery(gate=GateShape(outline="circle", inner_m=1.6, outer_m=2.4))
    assert np.abs(seen(square)[corner] - away).max() > 30
    assert np.abs(seen(ring)[corner] - away).max() == 0


def test_colours_are_drawn_between_low_and_high() -> None:
    blue = Scenery(gate_colour_low=(0.0, 0.0, 0.8), gate_colour_high=(0.1, 0.2, 1.0))
    colours = np.array([draw_look(np.random.default_rng(k), blue).gate_colour for k in range(50)])
    assert (colours >= (0.0, 0.0, 0.8)).all()
    assert (colours <= (0.1, 0.2, 1.0)).all()
    assert colours.std(axis=0).min() > 0.01


def test_pictures_lie_on_bars_and_on_the_ground(tmp_path: Path) -> None:
    squares = np.kron(np.indices((8, 8)).sum(axis=0) % 2, np.full((16, 16), 255))
    path = str(tmp_path / "squares.png")
    cv2.imwrite(path, squares.astype(np.uint8))
    white = Scenery(gate_colour_low=(1.0, 1.0, 1.0), gate_colour_high=(1.0, 1.0, 1.0))
    plain, printed = seen(white), seen(replace(white, gate_pictures=(path,)))
    changed = np.abs(plain.astype(int) - printed).max(axis=2) > 40
    assert 10 < changed.sum() < 200  # parts of the frame, of some 70 pixels
    assert not changed[28:36, 28:36].any()  # one sees through it
    ground = slice(40, 64)
    laid = seen(Scenery(ground_pictures=(path,)))
    assert not np.array_equal(laid[ground], seen(PLAIN)[ground])
    assert np.array_equal(laid[:28], seen(PLAIN)[:28])  # the sky


def test_a_picture_that_cannot_be_read_is_one_line(tmp_path: Path) -> None:
    (tmp_path / "no.png").write_text("not a picture")
    path = (str(tmp_path / "no.png"),)
    for scenery in (Scenery(gate_pictures=path), Scenery(ground_pictures=path)):
        with pytest.raises(UsageError, match=r"no\.png is no picture that can be read"):
            seen(scenery)
