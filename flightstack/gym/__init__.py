"""The simulation as a gymnasium environment, in process; importing this registers it.

import gymnasium
import flightstack.gym

env = gymnasium.make("flightstack/Gates-v0")

docs/gymnasium.md has spaces, rewards and ends. A policy of it flies over MAVLink, too:
`flightstack.fly(pilot=flightstack.gym.as_pilot(policy))`.
"""

from flightstack.gym.installed import check_installed

check_installed()

from flightstack.gym.gates import GatesEnv, register  # noqa: E402  after it is known to be there
from flightstack.gym.pilots import as_pilot, fly_in  # noqa: E402

register()
__all__ = ["GatesEnv", "as_pilot", "fly_in"]
