"""The environment: gymnasium's own checks, its seeds, its rewards and its ends."""

import importlib
import sys
import warnings
from collections.abc import Iterator
from typing import Any

import gymnasium
import numpy as np
import pytest
from gymnasium.utils.env_checker import check_env
from numpy.typing import NDArray

from flightstack.errors import UsageError
from flightstack.gym import GatesEnv, fly_in, installed
from flightstack.gym.gates import RANGE, velocities_of
from flightstack.records import Observation
from flightstack.training.seeds import TRAINING_TRACKS
from sitl import SitlError

ID = "flightstack/Gates-v0"
SLOWLY = np.array([-0.6, 0.0, 0.0, 0.1], np.float32)
CALM: dict[str, Any] = {"noise": (0.0, 0.0), "track_seed": 0}


@pytest.fixture
def env() -> Iterator[GatesEnv]:
    made = GatesEnv(**CALM)
    yield made
    made.close()


def steer(info: dict[str, Any], speed_m_s: float = 2.0) -> NDArray[np.float32]:
    """Fly to where the next gate is in truth."""
    forward, right, down, axis = info["gate"]
    ahead = max(1.0, float(np.hypot(forward, right)))
    velocities = np.array([forward, right, down, ahead * axis]) * speed_m_s / ahead
    return ((velocities - RANGE.offset) / RANGE.scale).astype(np.float32)


def flown(env: GatesEnv, images: int, **seeds: int) -> list[Any]:
    """Return all that some steps give."""
    told: list[Any] = [env.reset(options=seeds)]
    told += [env.step(SLOWLY * np.cos(number)) for number in range(images)]
    return told


def assert_same(ones: Any, others: Any) -> None:
    if isinstance(ones, dict):
        assert ones.keys() == others.keys()
        for key, value in ones.items():
            assert_same(value, others[key])
    elif isinstance(ones, tuple | list):
        for one, other in zip(ones, others, strict=True):
            assert_same(one, other)
    else:
        np.testing.assert_array_equal(ones, others)


def test_gymnasiums_own_checks_have_nothing_to_say() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(gymnasium.make(ID, render_mode="rgb_array").unwrapped)


def test_the_same_seeds_give_the_same_episode_to_the_last_bit(env: GatesEnv) -> None:
    first = flown(env, 12, seed=3, track_seed=4)
    assert_same(flown(env, 12, seed=3, track_seed=4), first)
    other = flown(env, 12, seed=5, track_seed=4)
    assert (other[-1][0]["image"] != first[-1][0]["image"]).any()


def test_one_seed_of_reset_draws_all_others(env: GatesEnv) -> None:
    drawn = [GatesEnv(noise=(1.0, 1.0)).reset(seed=9)[1] for _ in range(2)]
    assert_same(*drawn)
    assert drawn[0]["track_seed"] in TRAINING_TRACKS
    assert env.reset(seed=9)[1]["track_seed"] == 0  # it was asked for


@pytest.mark.parametrize("mode", ["sync", "async"])
def test_in_a_vector_each_is_as_it_is_alone(mode: str) -> None:
    images = 6
    vector = gymnasium.make_vec(ID, num_envs=2, vectorization_mode=mode, **CALM)
    alone = [GatesEnv(**CALM) for _ in range(2)]
    try:
        first, _ = vector.reset(seed=[1, 2])  # type: ignore[arg-type]
        steps = [vector.step(np.stack([SLOWLY, -SLOWLY])) for _ in range(images)]
        for number, env in enumerate(alone):
            observed, _ = env.reset(seed=1 + number)
            assert_same({k: v[number] for k, v in first.items()}, observed)
            for step in steps:
                observed, reward, *_ = env.step(SLOWLY if number == 0 else -SLOWLY)
                assert_same({k: v[number] for k, v in step[0].items()}, observed)
                assert step[1][number] == reward
    finally:
        vector.close()
        for env in alone:
            env.close()


def test_a_lap_is_rewarded_gate_by_gate_and_ends(env: GatesEnv) -> None:
    _, info = env.reset(seed=0)
    rewards: list[float] = []
    ended = False
    while not ended:
        before = info["gates_passed"]
        _, reward, terminated, truncated, info = env.step(steer(info))
        passed = info["gates_passed"] - before
        assert reward == pytest.approx(passed, abs=0.02)  # 0.1 a metre, at 2 m/s
        rewards.append(reward)
        ended = terminated or truncated
    assert (terminated, truncated) == (True, False)
    assert (info["gates_passed"], info["outcome"]) == (8, "completed")
    approach_m = (sum(rewards) - 8.0) / 0.1
    assert 30.0 < approach_m < 55.0  # once around a circle of 8 m, with no way back


def test_progress_is_rewarded_by_the_metre_or_not_at_all() -> None:
    for share in (0.0, 1.0):
        env = GatesEnv(**CALM, progress_reward=share)
        _, info = env.reset(seed=0)
        before = np.linalg.norm(info["gate"][:3])
        _, reward, *_, info = env.step(steer(info))
        gained = share * (before - np.linalg.norm(info["gate"][:3]))
        assert reward == pytest.approx(float(gained), abs=1e-5)
        env.close()


def test_it_ends_near_the_ground(env: GatesEnv) -> None:
    env.reset(seed=0)
    for _ in range(100):
        _, reward, terminated, truncated, info = env.step(np.array([-0.75, 0, 1, 0], np.float32))
        if terminated:
            break
    assert (info["outcome"], terminated, truncated) == ("near_ground", True, False)
    assert reward < -0.9


def test_without_a_gate_for_20_s_it_is_cut_off(env: GatesEnv) -> None:
    env.reset(seed=0)
    still = ((0.0 - RANGE.offset) / RANGE.scale).astype(np.float32)
    images, truncated = 0, False
    while not truncated:
        *_, terminated, truncated, info = env.step(still)
        assert not terminated
        images += 1
    assert info["outcome"] == "timeout"
    assert images == pytest.approx(401, abs=1)


def test_a_touched_gate_is_a_collision_and_costs_one(env: GatesEnv) -> None:
    _, info = env.reset(seed=0)
    while True:
        aim = {"gate": info["gate"] + np.array([0.0, 0.7, 0.0, 0.0])}  # the frame's right side
        _, reward, terminated, _, info = env.step(steer(aim))
        if terminated:
            break
    assert info["outcome"] in ("collision", "missed_gate")
    assert reward == pytest.approx(-1.0, abs=0.02)
    assert info["gates_passed"] == 0


def test_a_late_camera_is_late_here_too_and_the_estimate_is_of_the_image() -> None:
    env = GatesEnv(**CALM, conditions={"camera.latency_s": 0.2})
    observed, info = env.reset(seed=0)
    turned = [observed["attitude"][2]]
    for _ in range(12):
        observed, *_, info = env.step(np.array([-0.25, 0.0, 0.0, 1.0], np.float32))
        turned.append(observed["attitude"][2])
    now_us = env._flight._simulation.time_us if env._flight else 0
    assert now_us - info["stamp_us"] == pytest.approx(200_000, abs=4_000)
    assert abs(turned[2] - turned[0]) < 0.01  # not yet seen
    assert turned[-1] - turned[0] > 0.05
    env.close()


def test_actions_are_clipped_to_their_range() -> None:
    np.testing.assert_array_equal(velocities_of(np.full(4, 9.0)), RANGE.high)
    np.testing.assert_array_equal(velocities_of(np.full(4, -9.0)), RANGE.low)
    np.testing.assert_array_equal(velocities_of(np.zeros(4)), [3.0, 0.0, 0.0, 0.0])


class Remembering:
    """Flies straight on, and counts."""

    def __init__(self) -> None:
        self.images, self.resets = 0, 0

    def reset(self) -> None:
        self.images, self.resets = 0, self.resets + 1

    def act(self, observation: Observation) -> tuple[list[float], NDArray[np.float64]]:
        assert observation.image.shape == (64, 64, 3)
        self.images += 1
        return [2.0, 0.0, 0.5, 0.0], np.full(4, 0.5)


def test_an_end_to_end_policy_flies_here(env: GatesEnv) -> None:
    pilot = Remembering()
    ends = [fly_in(env, pilot, seed=1) for _ in range(2)]
    assert_same(*ends)
    assert pilot.resets == 2
    assert ends[0]["outcome"] in ("missed_gate", "collision")
    assert ends[0]["reward"] < 0.0


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"direction": "up"}, "direction must be 'cw' or 'ccw', got 'up'"),
        ({"render_mode": "human"}, "render_mode must be None or 'rgb_array', got 'human'"),
        ({"conditions": {"camera.late": 1.0}}, "camera.late: unknown key"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(options: dict[str, Any], words: str) -> None:
    with pytest.raises((UsageError, SitlError), match=words) as refusal:
        GatesEnv(**options)
    assert "\n" not in str(refusal.value)


def test_an_unknown_option_of_reset_is_refused(env: GatesEnv) -> None:
    with pytest.raises(UsageError, match="options are seed and track_seed"):
        env.reset(options={"track": 1})
    with pytest.raises(UsageError, match="reset first"):
        GatesEnv().step(SLOWLY)


def test_without_gymnasium_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(installed, "LIBRARIES", ("no_such_library",))
    monkeypatch.delitem(sys.modules, "flightstack.gym")
    with pytest.raises(UsageError, match=r"this needs no_such_library: .*\[gym\]"):
        importlib.import_module("flightstack.gym")
