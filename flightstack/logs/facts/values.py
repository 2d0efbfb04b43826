"""Values fit for JSON."""

from typing import Any

import numpy as np

Facts = dict[str, Any]


def rounded(value: float | np.floating[Any] | None, digits: int = 3) -> float | None:
    """Return a number fit for JSON: finite and short, else None."""
    if value is None or not np.isfinite(value):
        return None
    return round(float(value), digits)
