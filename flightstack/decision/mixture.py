"""Moments of the pool of N x M Gaussians, and where its variance comes from."""

from dataclasses import dataclass

import numpy as np

from flightstack.arrays import PerVelocity
from flightstack.records import ActionSamples


@dataclass(frozen=True, slots=True, kw_only=True)
class VarianceParts:
    """The variance of the pool by the law of total variance; the parts add up exactly."""

    aleatoric: PerVelocity  # mean predicted variance
    policy: PerVelocity  # variance between the members' mean predictions
    latent: PerVelocity  # mean over members of the variance between latent samples

    @property
    def total(self) -> PerVelocity:
        """The variance of the pool."""
        return self.aleatoric + self.policy + self.latent


def pool_mean(samples: ActionSamples) -> PerVelocity:
    """Mean of the pool: the ensemble mean of Lakshminarayanan et al. 2017."""
    return np.asarray(samples.mean.mean(axis=(0, 1)))


def split_variance(samples: ActionSamples) -> VarianceParts:
    """Split the variance of the pool: noise, policy members, latent samples."""
    member_mean = samples.mean.mean(axis=1)  # (N, 4)
    within = samples.mean - member_mean[:, np.newaxis]
    between = member_mean - member_mean.mean(axis=0)
    return VarianceParts(
        aleatoric=samples.var.mean(axis=(0, 1)),
        policy=np.square(between).mean(axis=0),
        latent=np.square(within).mean(axis=(0, 1)),
    )
