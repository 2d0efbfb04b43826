"""Uncertainty-aware navigation for MAVLink vehicles: perception, policy, decision, companion.

import flightstack

result = flightstack.fly(track_seed=7, noise=(1.0, 2.0), policy="my_package:make_policy")
print(result.outcome, result.gates_passed, result.log)
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from flightstack.launch import FlightResult, fly

__version__ = "0.1.0"
__all__ = ["FlightResult", "__version__", "fly"]


def __getattr__(name: str) -> Any:
    """Load what has a name when it is first used (PEP 562)."""
    if name in __all__:
        return getattr(import_module("flightstack.launch"), name)
    raise AttributeError(f"module 'flightstack' has no attribute {name!r}")
