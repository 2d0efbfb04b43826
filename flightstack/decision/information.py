"""How much each member's predictions say beyond the pool's: the MI score, two ways.

With m the pool of all N x M Gaussians, the score of member n is, for each velocity separately,

    S_n = mean over its M latent samples of KL( N(mu_n(z_i), sigma_n^2(z_i)) || m ).

`gaussian_score` replaces m by the Gaussian of the same mean and variance: closed form, fast, as the
author does it. `quadrature_score` takes m as it is: exact up to a quadrature, at most ln(N M).

References:
    Arnez et al. 2022, eq. 2-4. Poole et al. 2019, "On variational bounds of mutual information".
"""

import numpy as np
from numpy.typing import NDArray

from flightstack.arrays import PerMember
from flightstack.records import ActionSamples

NODES = 20  # Gauss-Hermite; error below 0.01 nats


def gaussian_score(samples: ActionSamples) -> PerMember:
    """Score every member against the Gaussian that matches the pool, in nats."""
    mean, var = samples.mean, samples.var
    centred = mean - mean.mean(axis=(0, 1))
    spread = var + np.square(centred)  # (N, M, 4): E (y - pool mean)^2 under each component
    pool_var = spread.mean(axis=(0, 1))
    excess = np.log(pool_var) - np.log(var).mean(axis=1) + spread.mean(axis=1) / pool_var - 1.0
    score: PerMember = 0.5 * excess
    return score


def quadrature_score(samples: ActionSamples) -> PerMember:
    """Score every member against the pool itself, in nats."""
    members, latents, velocities = samples.mean.shape
    score = np.empty((members, velocities))
    for k in range(velocities):
        mean, std = samples.mean[..., k].ravel(), np.sqrt(samples.var[..., k].ravel())
        points = mean[:, np.newaxis] + std[:, np.newaxis] * _NODES  # (N M, nodes)
        own = -0.5 * np.square(_NODES) - np.log(std)[:, np.newaxis]
        pool = np.log(_mean_density(points.ravel(), mean, std)).reshape(points.shape)
        divergence = (own - pool) @ _WEIGHTS  # the constants of both densities cancel
        score[:, k] = divergence.reshape(members, latents).mean(axis=1)
    return score


def _mean_density(
    points: NDArray[np.float64], mean: NDArray[np.float64], std: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Mean of the N(mean, std^2) densities at each point, times sqrt(2 pi).

    Single precision is four times as fast, and good to 1e-3 nats even for components 5,000 sigma
    apart. Never zero: every point lies within 8 sigma of a component of its own.
    """
    start = mean.min()  # counted from here, so that single precision loses little
    at, centre, unit = (x.astype(np.float32) for x in (points - start, mean - start, 1.0 / std))
    exponent = at[:, np.newaxis] * unit
    exponent -= centre * unit
    np.square(exponent, out=exponent)
    exponent *= np.float32(-0.5)
    np.exp(exponent, out=exponent)
    return np.asarray(exponent @ unit, dtype=np.float64) / len(mean)


_NODES, _WEIGHTS = np.polynomial.hermite_e.hermegauss(NODES)  # weight exp(-x^2 / 2)
_WEIGHTS = _WEIGHTS / _WEIGHTS.sum()
