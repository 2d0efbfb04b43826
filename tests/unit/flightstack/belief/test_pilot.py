"""From a belief to commands: gate after gate, on the side that was told, and unsure if it is."""

import math
from dataclasses import replace

import numpy as np
import pytest

from flightstack.belief.course import weigh
from flightstack.belief.pilot import BeliefSettings, OwnMotion, act, choose, see
from flightstack.belief.records import Belief, PassedGate
from flightstack.records import Pose
from tests.unit.flightstack.belief.made_gates import Point, pose_at, seen

SETTINGS = BeliefSettings()
RADIUS_M, GATES = 8.0, 8


def circle(direction: float) -> list[tuple[Point, float]]:
    """Return a course of gates around (0, 8 * direction), begun at the origin, northwards."""
    gates: list[tuple[Point, float]] = []
    for index in range(GATES):
        angle = (index + 0.5) * 2 * math.pi / GATES
        north, east = RADIUS_M * math.sin(angle), direction * RADIUS_M * (1 - math.cos(angle))
        gates.append(((north, east, -3.0), direction * angle))
    return gates


def visible(gates: list[tuple[Point, float]], pose: Pose) -> list[tuple[Point, float]]:
    found = []
    for centre, axis in gates:
        offset = np.array(centre) - np.array(pose.position_ned)
        bearing = math.atan2(offset[1], offset[0]) - pose.yaw_rad
        if abs(math.remainder(bearing, 2 * math.pi)) < 0.75 and 0.6 < np.linalg.norm(offset) < 9.0:
            found.append((centre, axis))
    return found


def fly(gates: list[tuple[Point, float]], chosen: BeliefSettings, seconds: float) -> list[Point]:
    """Fly a vehicle that does what it is told at once; where it believes that it passed gates."""
    rng, belief = np.random.default_rng(0), Belief()
    position, yaw = np.array([0.0, 0.0, -3.0]), 0.0
    velocity = np.zeros(3)
    for step in range(round(seconds * 20)):
        pose = pose_at(
            (float(position[0]), float(position[1]), float(position[2])), yaw, step * 50_000
        )
        pose = replace(pose, roll_rad=0.0, pitch_rad=0.0)
        belief = see(belief, seen(visible(gates, pose), pose), pose, chosen)
        belief, gate = choose(belief, pose, chosen)
        moved = (float(velocity[0]), float(velocity[1]), float(velocity[2]))
        pose = replace(pose, velocity_ned=moved)
        samples = act(belief, gate, OwnMotion(pose=pose, displacement_m_s=moved), chosen, rng)
        forward, right, down, rate = samples.mean[0].mean(axis=0).tolist()
        velocity = np.array(
            [
                math.cos(yaw) * forward - math.sin(yaw) * right,
                math.sin(yaw) * forward + math.cos(yaw) * right,
                down,
            ]
        )
        position, yaw = position + velocity * 0.05, yaw + rate * 0.05
    return [gate.position_ned for gate in belief.passed]


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_a_course_is_flown_in_order_whichever_way_it_turns(direction: float) -> None:
    gates = circle(direction)
    passed = fly(gates, SETTINGS, 40.0)
    assert len(passed) > GATES
    for index, place in enumerate(passed):
        assert place == pytest.approx(gates[index % GATES][0], abs=0.3)


@pytest.mark.parametrize(("side", "outwards"), [("left", 1.0), ("right", -1.0)])
def test_of_two_side_by_side_it_takes_the_side_that_was_told(side: str, outwards: float) -> None:
    gates = circle(1.0)
    twins = [
        (
            (
                north - 2.4 * outwards * math.sin(axis),
                east + 2.4 * outwards * math.cos(axis),
                -3.0,
            ),
            axis,
        )
        for (north, east, _), axis in gates
    ]
    passed = fly([*gates, *twins], replace(SETTINGS, pair_side=side), 36.0)
    assert len(passed) >= GATES
    for index, place in enumerate(passed[:GATES]):
        assert place == pytest.approx(gates[index][0], abs=0.3)


def test_a_gate_that_was_just_passed_is_not_next() -> None:
    pose = pose_at((6.5, 0.0, -3.0))
    belief = see(Belief(), seen([((6.0, 0.0, -3.0), 0.0)], pose_at()), pose_at(), SETTINGS)
    belief = replace(
        belief,
        tracks=replace(belief.tracks, log_odds=np.array([3.0])),
        passed=(PassedGate(number=0, position_ned=(6.0, 0.0, -3.0), axis_rad=0.0),),
    )
    assert np.isneginf(weigh(belief, pose, SETTINGS.course, None)).all()


def test_without_a_gate_it_looks_for_one_and_stands() -> None:
    motion = OwnMotion(pose=pose_at(), displacement_m_s=(0.0, 0.0, 0.0))
    samples = act(Belief(), None, motion, SETTINGS, np.random.default_rng(0))
    forward, right, down, rate = samples.mean[0].mean(axis=0).tolist()
    assert (forward, right, down) == pytest.approx((0.0, 0.0, 0.0))
    assert rate > 0.0


def test_the_less_is_known_the_more_the_commands_differ() -> None:
    pose = pose_at()
    motion = OwnMotion(pose=pose, displacement_m_s=(0.0, 0.0, 0.0))
    spread = []
    for std_m in (0.05, 0.8):
        belief = Belief()
        for _ in range(3):
            belief = see(belief, seen([((4.0, 0.0, -3.0), 0.0)], pose, std_m=std_m), pose, SETTINGS)
        belief, gate = choose(belief, pose, SETTINGS)
        samples = act(belief, gate, motion, SETTINGS, np.random.default_rng(0))
        spread.append(samples.mean[0, :, 1].std())
    assert spread[0] < spread[1]


def test_a_velocity_that_the_estimate_only_dreams_is_added_to_the_command() -> None:
    pose = replace(pose_at(), roll_rad=0.0, pitch_rad=0.0, velocity_ned=(0.5, 0.0, 0.0))
    honest = replace(pose, velocity_ned=(0.0, 0.0, 0.0))
    belief = Belief()
    for _ in range(3):
        belief = see(belief, seen([((5.0, 0.0, -3.0), 0.0)], pose), pose, SETTINGS)
    belief, gate = choose(belief, pose, SETTINGS)
    still = (0.0, 0.0, 0.0)
    commands = [
        act(belief, gate, OwnMotion(pose=each, displacement_m_s=still), SETTINGS,
            np.random.default_rng(0)).mean[0].mean(axis=0)
        for each in (honest, pose)
    ]  # fmt: skip
    assert commands[1] - commands[0] == pytest.approx([0.5, 0.0, 0.0, 0.0], abs=1e-9)
