"""`flightstack/Gates-v0`: fly through gates by what the camera sees."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, ClassVar

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from flightstack.arrays import PerVelocity, SmallRgb
from flightstack.errors import UsageError
from flightstack.gym.flight import CourseRequest, GateFlight, read_day
from flightstack.gym.scoring import Score, judge
from flightstack.policy.scales import VelocityRange
from flightstack.records import VELOCITIES, Observation
from flightstack.training.seeds import TRAINING_TRACKS
from sitl import CAMERA_RATE_HZ

ID = "flightstack/Gates-v0"
ENTRY_POINT = "flightstack.gym.gates:GatesEnv"
FINE_DAY: Mapping[str, Any] = MappingProxyType({})
FASTEST_M_S = 50.0  # no velocity of this vehicle reaches it
VEHICLE_SEEDS = 2**31
RANGE = VelocityRange()  # of every pilot's commands
Observed = dict[str, NDArray[Any]]
Action = NDArray[np.float32]


class GatesEnv(gymnasium.Env[Observed, Action]):
    """One course of gates; docs/gymnasium.md has what is seen, done, rewarded, and when it ends."""

    metadata: ClassVar[dict[str, Any]] = {  # type: ignore[misc]
        "render_modes": ["rgb_array"],
        "render_fps": CAMERA_RATE_HZ,
    }

    def __init__(
        self,
        *,
        noise: tuple[float, float] = (1.0, 2.0),
        track_seed: int | None = None,
        direction: str = "cw",
        laps: int = 1,
        conditions: Mapping[str, Any] = FINE_DAY,
        progress_reward: float = 0.1,
        render_mode: str | None = None,
    ) -> None:
        """Make it; `noise` is that of the gates' radius and height, m.

        `track_seed` None draws a track of TRAINING_TRACKS for each episode. `conditions` are those
        of docs/conditions.md, as {"camera.latency_s": 0.1}. `progress_reward` is for each metre
        towards the next gate.
        """
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise UsageError(f"render_mode must be None or 'rgb_array', got {render_mode!r}")
        if direction not in ("cw", "ccw"):
            raise UsageError(f"direction must be 'cw' or 'ccw', got {direction!r}")
        self.render_mode = render_mode
        self.observation_space: spaces.Dict[Any] = spaces.Dict(  # type: ignore[assignment]
            {
                "image": spaces.Box(0, 255, (64, 64, 3), np.uint8),
                "velocity": spaces.Box(-FASTEST_M_S, FASTEST_M_S, (3,), np.float32),
                "attitude": spaces.Box(-np.pi, np.pi, (3,), np.float32),
            }
        )
        self.action_space = spaces.Box(-1.0, 1.0, (len(VELOCITIES),), np.float32)
        self._request = CourseRequest(
            noise_m=(noise[0], noise[1]),
            direction=direction,
            laps=laps,
            conditions=read_day(conditions),
        )
        self._track_seed, self._progress_reward = track_seed, progress_reward
        self._flight: GateFlight | None = None
        self._score = Score()

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Observed, dict[str, Any]]:
        """Begin an episode; `options` may name its `seed` and `track_seed`, instead of chance."""
        super().reset(seed=seed)
        drawn = {
            "seed": int(self.np_random.integers(VEHICLE_SEEDS)),
            "track_seed": int(self.np_random.integers(TRAINING_TRACKS.start, TRAINING_TRACKS.stop)),
        }
        fixed = {} if self._track_seed is None else {"track_seed": self._track_seed}
        seeds = {**drawn, **fixed, **(options or {})}
        if set(seeds) != set(drawn):
            raise UsageError(f"reset: options are seed and track_seed, got {options!r}")
        self.close()
        self._flight = GateFlight(self._request, **seeds)
        self._score = Score.at_start(self._flight)
        return self._observe(self._flight), self._tell(self._flight) | seeds

    def step(self, action: Action) -> tuple[Observed, float, bool, bool, dict[str, Any]]:
        """Fly by an action until the next image; what lies outside the space is clipped."""
        flight = self._flight
        if flight is None:
            raise UsageError("step: reset first")
        flight.fly(velocities_of(action))
        self._score = judge(self._score, flight, progress_reward=self._progress_reward)
        score = self._score
        return (
            self._observe(flight),
            score.reward,
            score.terminated,
            score.truncated,
            self._tell(flight),
        )

    def render(self) -> SmallRgb | None:
        """Return the newest image."""
        if self._flight is None or self.render_mode is None:
            return None
        return self._flight.observation.image

    def close(self) -> None:
        """Free the physics engine and the renderer."""
        if self._flight is not None:
            self._flight.close()
            self._flight = None

    def _observe(self, flight: GateFlight) -> Observed:
        return as_dict(flight.observation)

    def _tell(self, flight: GateFlight) -> dict[str, Any]:
        """Say what is true, but not for a policy to see."""
        passed, total = flight.gates
        return {
            "stamp_us": flight.observation.stamp_us,
            "gates_passed": passed,
            "gates_total": total,
            "gate": np.array(flight.due_gate, np.float32),
            "outcome": self._score.outcome,
        }


def velocities_of(action: NDArray[Any]) -> PerVelocity:
    """Return m/s and rad/s of an action, -1 to 1 of each velocity's range; others are clipped."""
    return RANGE.offset + RANGE.scale * np.clip(np.asarray(action, np.float64), -1.0, 1.0)


def as_dict(observation: Observation) -> Observed:
    """Return what a policy of the environment is told, from what one in flight is."""
    return {
        "image": observation.image,
        "velocity": observation.velocity,
        "attitude": observation.attitude,
    }


def register() -> None:
    """Make it known to gymnasium, once."""
    if ID not in gymnasium.registry:
        gymnasium.register(id=ID, entry_point=ENTRY_POINT)
