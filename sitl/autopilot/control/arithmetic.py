"""Arithmetic with limits, and with numbers of which NaN stands for one that is not given."""

from math import hypot, isnan, sqrt


def clamp(value: float, size_max: float) -> float:
    """Keep within -size_max..size_max; NaN stays."""
    return -size_max if value < -size_max else size_max if value > size_max else value


def add(a: float, b: float) -> float:
    """Sum of what is given; NaN if neither is."""
    total = a + b
    if isnan(total):
        return b if isnan(a) else a
    return total


def add_or_zero(a: float, b: float) -> float:
    """Sum of what is given; 0 if neither is."""
    if isnan(b):
        return 0.0 if isnan(a) else a
    return b if isnan(a) else a + b


def or_zero(value: float) -> float:
    """Give the number, or 0 where there is none."""
    return 0.0 if isnan(value) else value


def add_limited(
    first: tuple[float, float], second: tuple[float, float], limit: float
) -> tuple[float, float]:
    """Add two horizontal vectors within a limit on the norm; the first is served first."""
    x, y = add(first[0], second[0]), add(first[1], second[1])
    norm = hypot(x, y)
    if not norm > limit:
        return (x, y)
    fx, fy = or_zero(first[0]), or_zero(first[1])
    sx, sy = or_zero(second[0]), or_zero(second[1])
    first_norm, second_norm = hypot(fx, fy), hypot(sx, sy)
    if first_norm >= limit:
        if limit == 0.0:
            return (0.0, 0.0)
        return (fx * limit / first_norm, fy * limit / first_norm)
    # How far along the second vector the limit is reached.
    ux, uy = sx / second_norm, sy / second_norm
    along = ux * fx + uy * fy
    room = -along + sqrt(along * along + limit * limit - first_norm * first_norm)
    return (fx + room * ux, fy + room * uy)
