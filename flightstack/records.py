"""The records that travel between the rooms of flightstack.

One alphabet: N policies, M latent samples, Z latent dimensions, and 4 velocities in the order
(vx, vy, vz, yaw rate): body frame, forward-right-down, m/s and rad/s, yaw rate clockwise positive.
"""

from dataclasses import dataclass, fields

import numpy as np

from flightstack.arrays import (
    CountPerVelocity,
    GateCovariances,
    GatePositions,
    PerAxis,
    PerGate,
    PerMember,
    PerSample,
    PerVelocity,
    Rgb,
    SmallRgb,
)

VELOCITIES = ("vx", "vy", "vz", "yaw_rate")  # m/s, m/s, m/s, rad/s; body FRD
ALL_MEMBERS = -1  # Decision.member where every policy was pooled


@dataclass(frozen=True, slots=True, kw_only=True)
class Image:
    """One camera image, stamped in vehicle time."""

    stamp_us: int
    sequence: int
    rgb: Rgb
    age_s: float = 0.0  # when it was received, vehicle time


@dataclass(frozen=True, slots=True, kw_only=True)
class Pose:
    """Where the vehicle says that it was at one moment."""

    time_us: int
    position_ned: tuple[float, float, float]  # m
    velocity_ned: tuple[float, float, float]  # m/s
    roll_rad: float
    pitch_rad: float
    yaw_rad: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Observation:
    """What an end-to-end policy is told: an image, and the vehicle's own estimate at its stamp."""

    stamp_us: int  # vehicle time
    image: SmallRgb
    velocity: PerAxis  # m/s: forward, right, down; level axes along the heading, as of commands
    attitude: PerAxis  # rad: roll, pitch, yaw (clockwise from north)


@dataclass(frozen=True, slots=True, kw_only=True)
class ActionSamples:
    """The posterior predictive: N x M Gaussians over each of the 4 velocities."""

    mean: PerSample  # m/s, rad/s
    var: PerSample  # squared units

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

    command: PerVelocity  # m/s, rad/s
    aleatoric_std: PerVelocity  # expected predicted noise
    epistemic_std: PerVelocity  # spread between policy members
    perceptual_std: PerVelocity  # spread between latent samples
    score: PerMember  # nats, MI score of each member
    member: CountPerVelocity  # the chosen one, or ALL_MEMBERS
    modes: CountPerVelocity  # number of modes of what was decided on
    member_mean: PerMember  # m/s, rad/s; each member's own prediction


@dataclass(frozen=True, slots=True, kw_only=True)
class GateDetections:
    """What one image shows: a set of K gates (0 to many), each with its own uncertainty.

    Positions are of the gates' centres from the camera, in the camera's axes (FRD: forward, right,
    down; they tilt with the vehicle). A gate looks the same from behind: headings count modulo pi.
    """

    position_frd: GatePositions  # m
    covariance_frd: GateCovariances  # m^2
    heading_rad: PerGate  # of the normal, clockwise from forward, in [-pi/2, pi/2)
    heading_std_rad: PerGate
    score: PerGate  # probability that a gate is there, 0 to 1
