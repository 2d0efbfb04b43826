"""The records that travel between the rooms of flightstack.

One alphabet: N policies, M latent samples, Z latent dimensions, and 4 velocities in the order
(vx, vy, vz, yaw rate): body frame, forward-right-down, m/s and rad/s, yaw rate clockwise positive.
"""

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

VELOCITIES = ("vx", "vy", "vz", "yaw_rate")  # m/s, m/s, m/s, rad/s; body FRD
ALL_MEMBERS = -1  # Decision.member where every policy was pooled


@dataclass(frozen=True, slots=True, kw_only=True)
class Image:
    """One camera image, stamped in vehicle time."""

    stamp_us: int
    sequence: int
    rgb: NDArray[np.uint8]  # (H, W, 3)


@dataclass(frozen=True, slots=True, kw_only=True)
class ActionSamples:
    """The posterior predictive: N x M Gaussians over each of the 4 velocities."""

    mean: NDArray[np.float64]  # (N, M, 4) m/s, rad/s
    var: NDArray[np.float64]  # (N, M, 4) squared units

    def __post_init__(self) -> None:
        """Check shapes and finiteness once, at the boundary."""
        for field in fields(self):
            array = getattr(self, field.name)
            if array.ndim != 3 or array.shape[2] != len(VELOCITIES) or 0 in array.shape:
                raise ValueError(
                    f"ActionSamples.{field.name}: expected (N, M, 4), got {array.shape}"
                )
            if not np.isfinite(array).all():
                raise ValueError(f"ActionSamples.{field.name}: not finite")
        if self.mean.shape != self.var.shape:
            raise ValueError(f"ActionSamples: mean {self.mean.shape} but var {self.var.shape}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Decision:
    """The command for one image, and all that is known about how sure it is."""

    command: NDArray[np.float64]  # (4,) m/s, rad/s
    aleatoric_std: NDArray[np.float64]  # (4,) expected predicted noise
    epistemic_std: NDArray[np.float64]  # (4,) spread between policy members
    perceptual_std: NDArray[np.float64]  # (4,) spread between latent samples
    score: NDArray[np.float64]  # (N, 4) nats, MI score of each member
    member: NDArray[np.int64]  # (4,) chosen member, or ALL_MEMBERS
    modes: NDArray[np.int64]  # (4,) number of modes of what was decided on
    member_mean: NDArray[np.float64]  # (N, 4) m/s, rad/s; each member's own prediction
