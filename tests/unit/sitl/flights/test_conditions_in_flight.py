"""Each condition does to a simulation what it says, and nothing where it is off."""

import itertools
import math
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from sitl.flown_vehicle import SimulationConfig
from sitl.records.conditions import read_conditions
from sitl.records.images import Image
from sitl.records.vehicle import OffboardSetpoint
from sitl.simulation import Simulation

HOVER = (0.0, 0.0, -3.0)


@pytest.fixture
def make() -> Iterator[Callable[..., Any]]:
    made: list[Simulation] = []

    def build(*changes: str, **config: Any) -> Simulation:
        made.append(
            Simulation(SimulationConfig(conditions=read_conditions(None, changes), **config))
        )
        made[-1].start_airborne(HOVER, 0.0)
        return made[-1]

    yield build
    for simulation in made:
        simulation.close()


def hover(
    simulation: Simulation, seconds: float
) -> tuple[list[tuple[int, Image]], list[tuple[float, float, float]]]:
    """Hold a place; the images, each with the time at which it came out, and the places."""
    images, places = [], []
    for tick in range(round(seconds * 250)):
        if simulation.image_due():
            stamp, image = simulation.image_stamp, simulation.render()
            assert stamp == (image.time_us, image.sequence)
            images.append((simulation.time_us, image))
        if tick % 12 == 0:
            simulation.autopilot.offboard_setpoint(
                OffboardSetpoint(time_us=simulation.time_us, position_ned=HOVER, yaw_rad=0.0)
            )
        simulation.step()
        places.append(simulation.state.position_ned)
    return images, places


def pictures(images: list[tuple[int, Image]]) -> NDArray[np.uint8]:
    return np.stack([image.rgb for _, image in images])


def test_a_late_camera_gives_the_same_pictures_with_the_same_stamps_later(
    make: Callable[..., Any],
) -> None:
    punctual, _ = hover(make(), 1.0)
    late, _ = hover(make("camera.latency_s=0.1"), 1.1)
    assert [(f.time_us, f.sequence) for _, f in late] == [
        (f.time_us, f.sequence) for _, f in punctual
    ]
    assert np.array_equal(pictures(late), pictures(punctual))
    assert late[0][0] == 0  # what waits for a first image need not wait for ever
    assert {came_us - image.time_us for came_us, image in late[1:]} == {100_000}


def test_a_mean_wind_pushes_and_the_autopilot_holds_against_it(make: Callable[..., Any]) -> None:
    _, calm = hover(make(perfect_estimate=True), 6.0)
    _, windy = hover(make("wind.mean_ned_m_s=[0, 5, 0]", perfect_estimate=True), 6.0)
    assert max(east for _, east, _ in calm) < 0.02
    assert max(east for _, east, _ in windy[:500]) > 0.1
    assert abs(windy[-1][1]) < 0.2


def test_gusts_come_by_the_seed(make: Callable[..., Any]) -> None:
    gusts = ("wind.gust_std_m_s=2.0",)
    first, again, other = (hover(make(*gusts, seed=seed), 1.0)[1][-1] for seed in (3, 3, 4))
    assert first == again
    assert math.dist(first, other) > 1e-3


def test_frozen_images_repeat_the_picture_before_and_keep_their_own_stamps(
    make: Callable[..., Any],
) -> None:
    images, _ = hover(make("camera.frozen_frame_share=0.5"), 4.0)
    shown = pictures(images)
    repeated = [np.array_equal(a, b) for a, b in itertools.pairwise(shown)]
    assert 0.3 < np.mean(repeated) < 0.7  # 79 draws: 0.5 +- 3.5 of 0.056
    stamps = [image.time_us for _, image in images]
    assert len(set(stamps)) == len(stamps) == 80


def test_pixel_noise_has_the_size_it_says(make: Callable[..., Any]) -> None:
    clear, noisy = (
        pictures(hover(make(*changes), 0.2)[0]).astype(float)
        for changes in ((), ("camera.noise_std_levels=10",))
    )
    inside = (clear > 60.0) & (clear < 195.0)  # where nothing is clipped
    difference = (noisy - clear)[inside]
    assert np.std(difference) == pytest.approx(10.0, rel=0.05)
    assert abs(np.mean(difference)) < 0.5


def test_blur_takes_edges_away_and_keeps_the_light(make: Callable[..., Any]) -> None:
    clear, blurred = (
        pictures(hover(make(*changes), 0.1)[0]).astype(float)
        for changes in ((), ("camera.blur_std_px=2",))
    )
    edges = [np.abs(np.diff(image, axis=2)).mean() for image in (clear, blurred)]
    assert edges[1] < 0.5 * edges[0]
    assert blurred.mean() == pytest.approx(clear.mean(), abs=1.0)


def test_darkness_leaves_its_share_of_the_light(make: Callable[..., Any]) -> None:
    bright, dark = (
        pictures(hover(make(*changes), 0.1)[0]).astype(float)
        for changes in ((), ("light.daylight_share=0.1",))
    )
    assert dark.mean() == pytest.approx(0.1 * bright.mean(), rel=0.05)


def test_fog_takes_contrast_with_the_distance(make: Callable[..., Any]) -> None:
    def contrast(*changes: str) -> list[np.float64]:
        simulation = make(*changes)
        gate = simulation.track.gates[0]
        seen = []
        for distance_m in (2.0, 6.0):
            north, east, down = gate.centre_ned
            at = (
                north - distance_m * math.cos(gate.yaw_rad),
                east - distance_m * math.sin(gate.yaw_rad),
                down,
            )
            simulation.start_airborne(at, gate.yaw_rad)
            image = simulation.render().rgb.astype(float)
            background = np.median(image[:20], axis=(0, 1))
            seen.append(np.abs(image[:40] - background).max())
        return seen

    (near, far), (clear_near, clear_far) = contrast("light.fog_visibility_m=10"), contrast()
    assert near < 0.7 * clear_near
    assert far < 0.35 * clear_far
    assert far < near


@pytest.mark.parametrize(("direction", "inwards_m"), [("cw", 2.4), ("ccw", 2.4), ("cw", -2.4)])
def test_a_second_gate_stands_beside_each_and_does_not_count(
    make: Callable[..., Any], direction: str, inwards_m: float
) -> None:
    simulation = make(f"course.decoy_inwards_m={inwards_m}", direction=direction)
    plain = make(direction=direction)
    assert simulation.track.gates == plain.track.gates
    centre = simulation.track.centre_ned
    for gate, decoy in zip(simulation.track.gates, simulation.track.decoys, strict=True):
        assert math.dist(gate.centre_ned, decoy.centre_ned) == pytest.approx(2.4)
        assert gate.yaw_rad == decoy.yaw_rad
        distances = [math.dist(g.centre_ned[:2], centre[:2]) for g in (gate, decoy)]
        assert (distances[1] < distances[0]) == (inwards_m > 0)
    assert simulation.course == plain.course
    at = simulation.track.decoys[0].centre_ned
    simulation.start_airborne((at[0], at[1], at[2] + 0.62), simulation.track.gates[0].yaw_rad)
    simulation.step()
    assert [event.kind for event in simulation.drain_course_events()] == ["collision"]
