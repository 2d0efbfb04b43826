"""Values fit for JSON."""

from typing import Any

import numpy as np

Facts = dict[str, Any]
MIN_RATE_SPAN_S = 1.0  # in less time a burst has no rate


def rounded(value: float | np.floating[Any] | None, digits: int = 3) -> float | None:
    """Return a number fit for JSON: finite and short, else None."""
    if value is None or not np.isfinite(value):
        return None
    return round(float(value), digits) + 0.0  # no negative zero


def rate_hz(count: int, span_s: float) -> float | None:
    """Return messages a second, None where they came in no time."""
    return rounded((count - 1) / span_s, 2) if span_s >= MIN_RATE_SPAN_S else None
