"""The frozen records of a belief, in the local NED in which telemetry tells positions.

Gates stand still in it but for the estimate's drift. Headings of gates count modulo pi.
"""

from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64, Int64
from numpy.typing import NDArray

Vector = Float64[NDArray[np.float64], " 3"]
Columns = Float64[NDArray[np.float64], " T"]
States = Float64[NDArray[np.float64], "T 6"]
StateCovariances = Float64[NDArray[np.float64], "T 6 6"]
Numbers = Int64[NDArray[np.int64], " T"]


@dataclass(frozen=True, slots=True, kw_only=True)
class GateTracks:
    """T gates, each with a Gaussian over position (m) and drift (m/s), and one over its heading."""

    number: Numbers  # each gate's own, never used again
    mean: States
    covariance: StateCovariances
    heading_rad: Columns
    heading_var: Columns
    log_odds: Columns  # that the gate exists
    hits: Numbers  # images in which it was seen

    def __len__(self) -> int:
        """Return T."""
        return len(self.number)

    @property
    def position_ned(self) -> Float64[NDArray[np.float64], "T 3"]:
        """Where they are believed, m."""
        return self.mean[:, :3]

    def take(self, rows: NDArray[np.intp] | NDArray[np.bool_]) -> "GateTracks":
        """Return some of them."""
        return GateTracks(
            number=self.number[rows],
            mean=self.mean[rows],
            covariance=self.covariance[rows],
            heading_rad=self.heading_rad[rows],
            heading_var=self.heading_var[rows],
            log_odds=self.log_odds[rows],
            hits=self.hits[rows],
        )


NO_TRACKS = GateTracks(
    number=np.zeros(0, np.int64),
    mean=np.zeros((0, 6)),
    covariance=np.zeros((0, 6, 6)),
    heading_rad=np.zeros(0),
    heading_var=np.zeros(0),
    log_odds=np.zeros(0),
    hits=np.zeros(0, np.int64),
)


@dataclass(frozen=True, slots=True, kw_only=True)
class PassedGate:
    """A gate that lies behind, where it was believed when it was passed."""

    number: int
    position_ned: tuple[float, float, float]
    axis_rad: float  # heading in which it was passed


@dataclass(frozen=True, slots=True, kw_only=True)
class Belief:
    """Everything that is believed at one moment."""

    time_us: int = -1  # before the first image
    tracks: GateTracks = NO_TRACKS
    passed: tuple[PassedGate, ...] = ()
    target: int | None = None  # the number of the gate that is flown to
    approach_rad: float = 0.0  # heading to the target when it was chosen
    numbers: int = 0  # given out so far


@dataclass(frozen=True, slots=True, kw_only=True)
class NextGate:
    """The gate that is believed to be next, and what comes after it."""

    number: int
    position_ned: Vector
    covariance: Float64[NDArray[np.float64], "3 3"]
    drift_ned: Vector  # m/s, of the estimate's frame against the gate
    axis_rad: float  # in which it is to be passed
    axis_std_rad: float
    following_ned: Vector  # where the gate after it is expected
    probability: float  # that it is the one
