"""The ensemble that flies: latent samples in, the posterior predictive out."""

from typing import Protocol, runtime_checkable

from flightstack.arrays import Latents
from flightstack.policy.networks import PolicyNetworks
from flightstack.policy.scales import VelocityRange
from flightstack.records import ActionSamples


@runtime_checkable
class Policy(Protocol):
    """Anything that turns latent samples into the posterior predictive."""

    def predict(self, z: Latents) -> ActionSamples:
        """Map latents to means and variances in m/s and rad/s."""
        ...


class PolicyEnsemble:
    """Every latent sample through every member: N x M Gaussians over each velocity."""

    def __init__(
        self,
        networks: PolicyNetworks,
        velocity_range: VelocityRange,
        variance_factor: tuple[float, ...] = (1.0, 1.0, 1.0, 1.0),
    ) -> None:
        self._networks = networks
        self._offset, self._scale = velocity_range.offset, velocity_range.scale
        self._var_scale = self._scale**2 * variance_factor

    def predict(self, z: Latents) -> ActionSamples:
        """Map latents to means and variances in m/s and rad/s."""
        mean, var = self._networks.moments(z)
        return ActionSamples(mean=mean * self._scale + self._offset, var=var * self._var_scale)
