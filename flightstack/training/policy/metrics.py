"""Judge a posterior predictive against the expert: RMSE, NLL and interval coverage."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from flightstack.arrays import PerComponent, PerImage, PerVelocity
from flightstack.records import VELOCITIES
from flightstack.training.errors import TrainingError
from flightstack.training.policy.calibration import INTERVAL, coverage, variance_factor


@dataclass(frozen=True, slots=True, kw_only=True)
class PolicyMetrics:
    """Figures over validation images, each of shape (4,): one for every velocity."""

    images: int
    rmse: tuple[float, ...]  # m/s, rad/s, of the pool's mean
    constant_rmse: tuple[float, ...]  # of the labels' mean
    nll: tuple[float, ...]  # nats, of the mixture
    coverage: tuple[float, ...]  # share of labels inside the mixture's central 90 % interval
    aleatoric_std: tuple[float, ...]  # root mean square over images, as the next two
    policy_std: tuple[float, ...]
    latent_std: tuple[float, ...]
    variance_factor: tuple[float, ...]  # that was applied before all of the above
    coverage_before: tuple[float, ...]  # of the variances as they were predicted
    member_nll: tuple[tuple[float, ...], ...]  # (N, 4) of each member's own mixture

    @property
    def best_member(self) -> tuple[int, ...]:
        """The member of least NLL for each velocity, (4,)."""
        return tuple(np.argmin(self.member_nll, axis=0).tolist())

    def curves(self) -> dict[str, float]:
        """Name what is followed over the epochs: nats, m/s and rad/s."""
        rmse = {f"rmse_{name}": value for name, value in zip(VELOCITIES, self.rmse, strict=True)}
        return {"nll": sum(self.nll), **rmse}

    def line(self) -> str:
        """Say it in one line of progress."""
        rmse = " ".join(f"{n} {v:.3f}" for n, v in zip(VELOCITIES, self.rmse, strict=True))
        cover = " ".join(f"{value:.0%}" for value in self.coverage)
        return f"NLL {sum(self.nll):.2f} nats, RMSE {rmse}, 90% intervals cover {cover}"

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON."""
        about = {"best_member": self.best_member}
        return {**asdict(self), **about, "velocities": list(VELOCITIES), "interval": INTERVAL}

    def require_healthy(self) -> None:
        """Raise TrainingError when a velocity was not learned."""
        for name, rmse, constant in zip(VELOCITIES, self.rmse, self.constant_rmse, strict=True):
            if not rmse < constant:
                raise TrainingError(
                    f"{name} was not learned: its error {rmse:.3f} is no better than a constant's, "
                    f"{constant:.3f}; look at the data, or train longer"
                )


def measure_policy(
    mean: PerComponent,  # m/s, rad/s
    var: PerComponent,
    target: PerImage,
    *,
    members: int,
    constant: PerVelocity,
) -> PolicyMetrics:
    """Compare mixtures of S Gaussians, member by member in the first axis, with the labels.

    All but `coverage_before` is of the mixtures as recalibrated on these very images.
    """
    before = coverage(mean, var, target)
    factor = variance_factor(mean, var, target)
    var = var * factor
    std = np.sqrt(var)
    log_density = -0.5 * np.square((target - mean) / std) - np.log(std) - 0.5 * np.log(2.0 * np.pi)
    by_member = mean.reshape(members, -1, *mean.shape[1:])  # (N, M, K, 4)
    member_density = log_density.reshape(by_member.shape)
    member_mean = by_member.mean(axis=1)
    return PolicyMetrics(
        images=len(target),
        rmse=_root_mean_square(mean.mean(axis=0) - target),
        constant_rmse=_root_mean_square(constant - target),
        nll=tuple((np.log(len(mean)) - logsumexp(log_density, axis=0)).mean(axis=0).tolist()),
        coverage=tuple(coverage(mean, var, target).tolist()),
        aleatoric_std=_root_mean_square(std),
        policy_std=_root_mean_square(member_mean - member_mean.mean(axis=0)),
        latent_std=_root_mean_square(by_member - member_mean[:, np.newaxis]),
        variance_factor=tuple(factor),
        coverage_before=tuple(before.tolist()),
        member_nll=_member_nll(member_density),
    )


def _member_nll(log_density: NDArray[np.float64]) -> tuple[tuple[float, ...], ...]:
    """Mean NLL of each member's own mixture: (N, M, K, 4) to (N, 4)."""
    nll = np.log(log_density.shape[1]) - logsumexp(log_density, axis=1)
    return tuple(tuple(row) for row in nll.mean(axis=1).tolist())


def _root_mean_square(errors: NDArray[np.float64]) -> tuple[float, ...]:
    axes = tuple(range(errors.ndim - 1))
    return tuple(np.sqrt(np.square(errors).mean(axis=axes)).tolist())
