"""Find how late images are: by which lag their turns follow the gyro's best, and how surely.

The turn from one image to the next is what the gyro has integrated between their exposures, each
the lag before its stamp. The lag with the highest correlation is the latency; resampling whole
seconds of the recording (moving blocks: Kuensch 1989) says how far it would be off another time.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from flightstack.calibration.image_turns import ImageTurns
from flightstack.errors import UsageError

FIRST_S, LAST_S, STEP_S = -0.1, 0.6, 0.001
BLOCK_S = 1.0
MIN_BLOCKS = 5
RESAMPLED = 400
MIN_TURNING_RAD_S = 0.25  # root mean square
MIN_CORRELATION = 0.8
OUTLIER = 5.0  # times the median error
INTERVAL = (2.5, 97.5)  # percent
REMEDY = "turn the vehicle by hand, quarter turns to and fro, for 15 s"

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True, kw_only=True)
class LatencyEstimate:
    """How late images are beside telemetry, with its 95 % interval; s."""

    latency_s: float
    low_s: float
    high_s: float
    correlation: float
    turns: int
    lasted_s: float


def find_latency(
    turns: ImageTurns, gyro_us: NDArray[np.int64], rate_rad_s: Floats
) -> LatencyEstimate:
    """Compare turns of the view with the gyro's yaw rate; UsageError where that says nothing.

    Stamps of both are vehicle time; `gyro_us` rises.
    """
    turns = _covered(turns, gyro_us)
    lags_s = np.arange(FIRST_S, LAST_S + STEP_S / 2, STEP_S)
    block = _blocks(turns)
    expected = _expected(turns, gyro_us / 1e6, rate_rad_s, lags_s)
    kept = _inliers(expected, turns.angle_rad)
    sums = _sums(expected[:, kept], turns.angle_rad[kept], block[kept])
    (best_s,), (correlation,) = _peaks(_correlations(sums.sum(axis=0)[None]), lags_s)
    if correlation < MIN_CORRELATION:
        raise UsageError(
            f"the images turn unlike the gyro (correlation {correlation:.2f}): {REMEDY}, in "
            "front of something with contrast"
        )
    low_s, high_s = np.percentile(_resampled(sums, lags_s), INTERVAL)
    return LatencyEstimate(
        latency_s=float(best_s),
        low_s=float(low_s),
        high_s=float(high_s),
        correlation=float(correlation),
        turns=int(np.count_nonzero(kept)),
        lasted_s=float(turns.to_us[-1] - turns.from_us[0]) / 1e6,
    )


def _blocks(turns: ImageTurns) -> NDArray[np.int_]:
    """Say in which second each turn begins; raises UsageError where they are too few."""
    begin_s = turns.from_us / 1e6
    block = np.floor((begin_s - begin_s[:1]) / BLOCK_S).astype(int)
    seconds = len(np.unique(block))
    if seconds < MIN_BLOCKS:
        raise UsageError(f"only {seconds} s of images and gyro together: {REMEDY}")
    return block


def _expected(turns: ImageTurns, gyro_s: Floats, rate_rad_s: Floats, lags_s: Floats) -> Floats:
    """Return what the gyro has turned between each two exposures, for each lag: (lags, turns)."""
    begin_s, end_s = turns.from_us / 1e6, turns.to_us / 1e6
    means = (rate_rad_s[1:] + rate_rad_s[:-1]) / 2
    angle = np.concatenate([[0.0], np.cumsum(means * np.diff(gyro_s))])
    expected = np.stack(
        [
            np.interp(end_s - lag, gyro_s, angle) - np.interp(begin_s - lag, gyro_s, angle)
            for lag in lags_s
        ]
    )
    turning = float(np.sqrt(np.mean((expected / (end_s - begin_s)) ** 2)))
    if turning < MIN_TURNING_RAD_S:
        raise UsageError(f"the vehicle turned by {turning:.2f} rad/s: too little; {REMEDY}")
    return expected


def _covered(turns: ImageTurns, gyro_us: NDArray[np.int64]) -> ImageTurns:
    """Return the turns for which there is gyro at every lag."""
    if not len(gyro_us):
        raise UsageError("the log holds neither HIGHRES_IMU nor ATTITUDE of the vehicle")
    begins = turns.from_us - round(LAST_S * 1e6) >= gyro_us[0]
    ends = turns.to_us - round(FIRST_S * 1e6) <= gyro_us[-1]
    kept = begins & ends
    return ImageTurns(
        from_us=turns.from_us[kept], to_us=turns.to_us[kept], angle_rad=turns.angle_rad[kept]
    )


def _inliers(expected: Floats, angle: Floats) -> NDArray[np.bool_]:
    """Leave out turns that no rotation explains, by the errors at the best lag of all."""
    every = np.zeros(len(angle), int)
    best = int(np.argmax(_correlations(_sums(expected, angle, every).sum(axis=0)[None])))
    slope, shift = np.polyfit(expected[best], angle, 1)
    error = np.abs(angle - slope * expected[best] - shift)
    return np.asarray(error <= OUTLIER * max(float(np.median(error)), 1e-6))


def _sums(expected: Floats, angle: Floats, block: NDArray[np.int_]) -> Floats:
    """Return n, x, y, xx, xy, yy of each block at each lag: (blocks, lags, 6)."""
    y = np.broadcast_to(angle, expected.shape)
    terms = np.stack(
        [np.ones_like(expected), expected, y, expected**2, expected * y, y**2], axis=-1
    )
    sums = np.zeros((block.max() + 1, len(expected), 6))
    np.add.at(sums, block, terms.transpose(1, 0, 2))
    return sums[sums[:, 0, 0] > 0]


def _correlations(sums: Floats) -> Floats:
    """Return Pearson's correlation from sums (..., lags, 6): (..., lags)."""
    n, x, y, xx, xy, yy = np.moveaxis(sums, -1, 0)
    spread = np.maximum((n * xx - x * x) * (n * yy - y * y), 1e-300)
    return np.asarray((n * xy - x * y) / np.sqrt(spread))


def _peaks(correlations: Floats, lags_s: Floats) -> tuple[Floats, Floats]:
    """Return each row's best lag, by a parabola through its three highest, and the height."""
    rows = np.arange(len(correlations))
    best = np.clip(np.argmax(correlations, axis=1), 1, len(lags_s) - 2)
    before, at, after = (correlations[rows, best + step] for step in (-1, 0, 1))
    bend = before - 2 * at + after
    step = np.where(bend < 0, 0.5 * (before - after) / np.where(bend < 0, bend, -1.0), 0.0)
    return lags_s[best] + np.clip(step, -1, 1) * STEP_S, at


def _resampled(sums: Floats, lags_s: Floats) -> Floats:
    rng = np.random.default_rng(0)
    chosen = rng.integers(0, len(sums), (RESAMPLED, len(sums)))
    return _peaks(_correlations(np.stack([sums[each].sum(axis=0) for each in chosen])), lags_s)[0]
