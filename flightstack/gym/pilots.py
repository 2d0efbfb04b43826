"""The same policy here and over MAVLink: as an end-to-end policy, and one of those flown here."""

import functools
from collections.abc import Callable
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from flightstack.companion.pilots.end_to_end import EndToEndPolicy, read_answer
from flightstack.gym.gates import RANGE, Action, Observed, as_dict, velocities_of
from flightstack.records import Observation

GymPolicy = Callable[[Observed], Any]  # to an action [and its standard deviations]


class GymPilot:
    """A policy of the environment as what `flightstack.fly(pilot=...)` and a companion fly."""

    def __init__(self, policy: GymPolicy, *, direction: str, seed: int) -> None:  # noqa: ARG002  no chance in it
        self._policy = policy

    def reset(self) -> None:
        """Have it forget, where it can remember."""
        getattr(self._policy, "reset", _nothing)()

    def act(self, observation: Observation) -> Any:
        """Answer an image."""
        answer = self._policy(as_dict(observation))
        if isinstance(answer, tuple) and len(answer) == 2:
            action, stds = answer
            return velocities_of(action), RANGE.scale * np.asarray(stds)
        return velocities_of(answer)


def as_pilot(policy: GymPolicy) -> Callable[..., GymPilot]:
    """Return the factory of a pilot that flies by a policy: a function from observation to action.

    It needs no more of the policy than cloudpickle can take along; where it has a `reset()`, that
    is called when a flight begins.
    """
    return functools.partial(GymPilot, policy)


def fly_in(
    env: gymnasium.Env[Observed, Action], pilot: EndToEndPolicy, *, seed: int | None = None
) -> dict[str, Any]:
    """Fly one episode by an end-to-end policy.

    Returns the last `info`, with the sum of all rewards as `reward`.
    """
    observed, info = env.reset(seed=seed)
    pilot.reset()
    total, ended = 0.0, False
    while not ended:
        answer = pilot.act(Observation(stamp_us=info["stamp_us"], **_renamed(observed)))
        command, _ = read_answer(answer)
        action = ((command - RANGE.offset) / RANGE.scale).astype(np.float32)
        observed, reward, terminated, truncated, info = env.step(action)
        total, ended = total + float(reward), terminated or truncated
    return info | {"reward": total}


def _renamed(observed: Observed) -> dict[str, NDArray[Any]]:
    return {name: observed[name] for name in ("image", "velocity", "attitude")}


def _nothing() -> None:
    """Forget nothing."""
