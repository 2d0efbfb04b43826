"""Check what a pilot gives: every array of a decision has its shape, and every number is finite."""

import numpy as np

from flightstack.companion.piloting.failure import PartError
from flightstack.records import VELOCITIES, ActionSamples, Decision

PER_VELOCITY = ("command", "aleatoric_std", "epistemic_std", "perceptual_std", "member", "modes")
PER_MEMBER = ("score", "member_mean")


def check_latents(z: object) -> None:
    """Raise PartError where these are no latent samples, (M, Z)."""
    if not isinstance(z, np.ndarray) or not np.issubdtype(z.dtype, np.floating):
        raise PartError(f"gave {_kind(z)}, not latents (M, Z), float32")
    if z.ndim != 2 or z.size == 0:
        raise PartError(f"gave latents of shape {z.shape}, not (M, Z)")
    if not np.isfinite(z).all():
        raise PartError("gave latents that are not finite")


def check_samples(samples: object) -> None:
    """Raise PartError where these are no ActionSamples, which check their own numbers."""
    if not isinstance(samples, ActionSamples):
        raise PartError(f"gave {type(samples).__name__}, not ActionSamples")


def fault_of(decision: object) -> str | None:
    """Say what is wrong with a decision; None where it can be flown by."""
    if not isinstance(decision, Decision):
        return f"gave {type(decision).__name__}, not a Decision"
    arrays = [getattr(decision, name) for name in (*PER_VELOCITY, *PER_MEMBER)]
    try:
        if np.isfinite(np.concatenate(arrays, axis=None)).all() and _fits(decision):
            return None
    except (TypeError, ValueError):
        pass
    return _first_fault(decision)


def _fits(decision: Decision) -> bool:
    width = len(VELOCITIES)
    return (
        decision.command.shape
        == decision.aleatoric_std.shape
        == decision.epistemic_std.shape
        == decision.perceptual_std.shape
        == decision.member.shape
        == decision.modes.shape
        == (width,)
        and decision.score.shape == decision.member_mean.shape
        and decision.score.shape[1:] == (width,)
        and decision.score.shape[0] > 0
        and bool((decision.member < decision.score.shape[0]).all())
    )


def _first_fault(decision: Decision) -> str:
    width = len(VELOCITIES)
    for name in (*PER_VELOCITY, *PER_MEMBER):
        value = getattr(decision, name)
        if not isinstance(value, np.ndarray) or not np.issubdtype(value.dtype, np.number):
            return f"gave {name} as {_kind(value)}, not as an array of numbers"
        wanted = f"({width},)" if name in PER_VELOCITY else f"(N, {width})"
        if value.shape[-1:] != (width,) or value.ndim != (1 if name in PER_VELOCITY else 2):
            return f"gave {name} of shape {value.shape}, not {wanted}"
        if not np.isfinite(value).all():
            return f"gave {name} that is not finite"
    return "gave arrays of different numbers of members"


def _kind(value: object) -> str:
    return f"an array of {value.dtype}" if isinstance(value, np.ndarray) else type(value).__name__
