"""Let joblib fly on a Ray cluster: the one that RAY_ADDRESS names, else one on this machine."""

import os
from typing import Any

from joblib import register_parallel_backend

from flightstack.errors import UsageError

NAME = "flightstack-ray"


def register() -> None:
    """Make the backend known to joblib by NAME; raises UsageError where Ray is missing."""
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    try:
        import ray  # noqa: PLC0415  an extra
        from ray.util.joblib.ray_backend import RayBackend  # noqa: PLC0415
    except ImportError as error:
        raise UsageError("--backend ray needs Ray: pip install 'flightstack[ray]'") from error

    class StreamingRay(RayBackend):
        """Hands over each trial as it lands, which joblib allows only where this is said."""

        supports_return_generator = True

    if not ray.is_initialized():
        settings: dict[str, Any] = {"log_to_driver": False, "logging_level": "error"}
        if "RAY_ADDRESS" not in os.environ:
            settings |= {"include_dashboard": False}
        ray.init(**settings)
    register_parallel_backend(NAME, StreamingRay)
