"""Which pilot the command line asks for: a model with its parts or others, or a user's own whole.

What loads it is imported when it is known to be needed: not every pilot needs every library.
"""

from dataclasses import dataclass

from flightstack.companion.piloting.protocols import GuardedPilot
from flightstack.errors import UsageError
from flightstack.mavlink.motion import MotionHistory

GB = 1e9
BY_ITSELF = "act"  # what a result says where other flights have a strategy


@dataclass(frozen=True, slots=True, kw_only=True)
class PilotChoice:
    """What is asked for, by the names of the command line's options."""

    model: str | None  # None where a pilot of the user's own needs none
    strategy: str | None = None  # None: the model's own, as for the next two
    perception: str | None = None
    policy: str | None = None
    pilot: str | None = None
    pair_side: str | None = None  # "left" or "right"
    direction: str = "cw"
    seed: int = 0
    part_memory_gb: float = 2.0

    def __post_init__(self) -> None:
        """Refuse a pilot of the user's own with parts beside it; raises UsageError."""
        if self.pilot is None:
            return
        for option in ("model", "strategy", "perception", "policy", "pair_side"):
            if getattr(self, option) is not None:
                name = option.replace("_", "-")
                raise UsageError(f"--{name}: not with --pilot, which flies from image to command")

    @property
    def names(self) -> tuple[str, str]:
        """What a result calls the model and the strategy."""
        if self.model is None:
            return self.pilot or "", BY_ITSELF
        from flightstack.models import recorded  # noqa: PLC0415

        return self.model, self.strategy or recorded(self.model).strategy


def load_pilot(choice: PilotChoice, motion: MotionHistory) -> GuardedPilot:
    """Load the pilot; code of a user's own works in a process of its own.

    `motion` is what telemetry tells. Raises UsageError or ModelError.
    """
    if choice.model is None:
        return _load_end_to_end(choice, choice.pilot or "", motion)
    from flightstack.gate_models import is_gate_model  # noqa: PLC0415

    if is_gate_model(choice.model):
        return _load_belief(choice, choice.model, motion)
    if choice.pair_side is not None:
        raise UsageError(f"--pair-side: {choice.model} has no belief of where gates are")
    return _load_pipeline(choice, choice.model)


def _load_end_to_end(choice: PilotChoice, name: str, motion: MotionHistory) -> GuardedPilot:
    from flightstack.companion.piloting.in_worker import WorkerPilot  # noqa: PLC0415
    from flightstack.companion.pilots.end_to_end import end_to_end_loader  # noqa: PLC0415

    load = end_to_end_loader(name, motion, choice.seed, direction=choice.direction)
    return WorkerPilot.start(load, motion, max_memory_bytes=choice.part_memory_gb * GB)


def _load_pipeline(choice: PilotChoice, model: str) -> GuardedPilot:
    from flightstack.companion.piloting.in_process import start_in_process  # noqa: PLC0415
    from flightstack.companion.piloting.in_worker import WorkerPilot  # noqa: PLC0415
    from flightstack.companion.pipeline import brings_parts, pipeline_loader  # noqa: PLC0415

    load = pipeline_loader(
        model,
        choice.strategy,
        choice.seed,
        direction=choice.direction,
        perception=choice.perception,
        policy=choice.policy,
    )
    if brings_parts(choice.strategy, choice.perception, choice.policy):
        return WorkerPilot.start(load, max_memory_bytes=choice.part_memory_gb * GB)
    return start_in_process(load)


def _load_belief(choice: PilotChoice, model: str, motion: MotionHistory) -> GuardedPilot:
    from flightstack.companion.belief_pilot import belief_loader  # noqa: PLC0415
    from flightstack.companion.piloting.in_process import start_in_process  # noqa: PLC0415
    from flightstack.companion.pipeline import brings_parts  # noqa: PLC0415

    if brings_parts(choice.strategy, None, None):
        raise UsageError(f"--strategy: {model} takes one of flightstack's own")
    for option in ("perception", "policy"):
        if getattr(choice, option) is not None:
            raise UsageError(f"--{option}: not with {model}, which flies by a belief")
    return start_in_process(
        belief_loader(
            model,
            choice.strategy,
            choice.seed,
            motion,
            direction=choice.direction,
            pair_side=choice.pair_side,
        )
    )
