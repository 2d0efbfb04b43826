"""Let joblib fly on a Ray cluster: the one that RAY_ADDRESS names, else one on this machine."""

import os
import sys
from typing import Any

from joblib import register_parallel_backend

from flightstack.errors import UsageError
from flightstack.libraries import require

NAME = "flightstack-ray"


def check_installed() -> None:
    """Raise MissingLibraryError where Ray is missing."""
    require("ray", "ray")


def register() -> None:
    """Make the backend known to joblib by NAME; raises UsageError where Ray does not start."""
    check_installed()
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    import ray  # noqa: PLC0415  an extra
    from ray.util.joblib.ray_backend import RayBackend  # noqa: PLC0415

    class StreamingRay(RayBackend):
        """Hands over each trial as it lands, which joblib allows only where this is said."""

        supports_return_generator = True

    if not ray.is_initialized():
        settings: dict[str, Any] = {"log_to_driver": False, "logging_level": "error"}
        if "RAY_ADDRESS" not in os.environ:
            settings |= {"include_dashboard": False}
        try:
            ray.init(**settings)
        except (OSError, RuntimeError, ValueError) as error:
            raise UsageError(f"Ray did not start ({error}): see RAY_ADDRESS and TMPDIR") from error
    register_parallel_backend(NAME, StreamingRay)


def worker_deaths() -> tuple[type[Exception], ...]:
    """Name what Ray raises when a worker dies; nothing where Ray has not been loaded."""
    if "ray" not in sys.modules:
        return ()
    from ray.exceptions import RayActorError, WorkerCrashedError  # noqa: PLC0415  an extra

    return RayActorError, WorkerCrashedError
