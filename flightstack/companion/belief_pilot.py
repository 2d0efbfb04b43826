"""Fly by a belief: what images show is remembered as a map of gates, and the next one is flown to.

image --> a set of gates --> belief, at the image's stamp --> M commands --> one command
perception         belief, with telemetry           its law      decision
"""

from dataclasses import replace

import numpy as np

from flightstack.arrays import SmallRgb
from flightstack.belief.pilot import BeliefSettings, OwnMotion, act, choose, see
from flightstack.belief.records import Belief
from flightstack.belief.settings import LawSettings
from flightstack.companion.piloting.failure import PERCEPTION, POLICY, STRATEGY, PartMarker
from flightstack.companion.piloting.protocols import PilotLoader, PilotMaker
from flightstack.decision.strategies import Strategy, make_strategy
from flightstack.gate_models import load_gate_model
from flightstack.mavlink.motion import MotionHistory
from flightstack.perception.gate_detector import GateDetector
from flightstack.perception.preprocessing import fit_image
from flightstack.policy.scales import VelocityRange
from flightstack.records import ActionSamples, Decision, Image

DISPLACED_OVER_S = 0.4  # shorter, the estimate's noise; longer, the vehicle has turned
ALONE = (0, 0, 0, 0)  # the one member of its ensemble
UNSURE_VAR = 1.0  # of every velocity, where no telemetry tells where the vehicle is


class BeliefPilot:
    """Decides for one image after another; a pure function of images, telemetry and the seed."""

    def __init__(
        self,
        detector: GateDetector,
        motion: MotionHistory,
        strategy: Strategy,
        settings: BeliefSettings,
        *,
        seed: int = 0,
        marker: PartMarker | None = None,
    ) -> None:
        self.belief = Belief()
        self._detector, self._motion = detector, motion
        self._strategy, self._settings = strategy, settings
        self._limits = VelocityRange()
        self._rng = np.random.default_rng(seed)
        self._mark = (PartMarker() if marker is None else marker).mark
        self._previous: SmallRgb | None = None

    def decide(self, image: Image) -> Decision:
        """See, believe, decide; without telemetry it stands still, and says that it is unsure."""
        rgb = fit_image(image.rgb)
        is_new = self._previous is None or not np.array_equal(rgb, self._previous)
        self._previous = rgb
        self._mark(PERCEPTION)
        detections = self._detector.detect(rgb) if is_new else None
        self._mark(POLICY)
        pose, now = self._motion.at(image.stamp_us), self._motion.latest
        if pose is None or now is None:
            return self._strategy.decide(_standing(self._settings.samples))
        if detections is not None:
            self.belief = see(self.belief, detections, pose, self._settings)
        displacement = self._motion.displacement_m_s(DISPLACED_OVER_S) or now.velocity_ned
        motion = OwnMotion(pose=now, displacement_m_s=displacement)
        self.belief, gate = choose(self.belief, now, self._settings)
        samples = act(self.belief, gate, motion, self._settings, self._rng)
        self._mark(STRATEGY)
        decision = self._strategy.decide(samples)
        return replace(decision, command=self._limits.clip(decision.command))


def belief_loader(
    model: str,
    strategy: str | None,
    seed: int,
    motion: MotionHistory,
    *,
    direction: str = "cw",
    pair_side: str | None = None,
) -> PilotLoader:
    """Return what loads a model once, then makes any number of equal pilots with it.

    `pair_side`, "left" or "right", is which of two gates side by side the mission means. Raises
    ModelError for the model, UsageError for the strategy, when it loads and when it makes.
    """

    def load(marker: PartMarker) -> PilotMaker:
        loaded = load_gate_model(model)
        settings = BeliefSettings(
            law=LawSettings(speed_m_s=loaded.config.speed_m_s), pair_side=pair_side
        )
        name = strategy or loaded.config.strategy

        def make() -> BeliefPilot:
            decides = make_strategy(name, direction=direction, seed=seed, best_member=ALONE)
            detector = loaded.detector
            return BeliefPilot(detector, motion, decides, settings, seed=seed, marker=marker)

        return make

    return load


def _standing(samples: int) -> ActionSamples:
    shape = (1, samples, 4)
    return ActionSamples(mean=np.zeros(shape), var=np.full(shape, UNSURE_VAR))
