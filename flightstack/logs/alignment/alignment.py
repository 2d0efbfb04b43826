"""Put two logs of one flight on one axis: by the vehicle's boot clock, else by its attitude.

Both logs hold the attitude with the time since boot. If both are of one boot, the same time since
boot means the same roll and pitch. Else one log is shifted along the other until they fit best.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from flightstack.libraries import load_library
from flightstack.logs.alignment.boot_clock_fit import BootClockFit, fit_boot_clock, lateness_us
from flightstack.logs.errors import LogFileError
from flightstack.logs.flight.flight import Flight

GRID_S = 0.02
MIN_OVERLAP_S = 5.0
MAX_RESIDUAL_RAD = 0.035  # 2 deg: two logs of one boot differ by rounding, and by rates
MIN_CORRELATION = 0.8
MIN_TILT_RAD = 0.01  # root mean square; less is no motion that could tell one time from another
TOLD_RATE = 1e-4  # smaller differences of the clocks' rates are those of any two quartzes
RESTART_MS = 1000  # the boot clock goes back by more: the vehicle started again

Floats = NDArray[np.float64]
Times = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Alignment:
    """How the other log's times become this log's, and how well both fit then."""

    method: str  # "boot time" or "attitude"
    clock: BootClockFit  # of this log
    other_clock: BootClockFit  # of the other
    shift_us: int  # boot time of this log minus that of the other: 0 where it is one boot
    late_ms: float  # by how much this log's packets were late, 95 % of them at most
    residual_rad: float  # root mean square of the difference in roll and pitch
    correlation: float  # of roll and pitch, -1 to 1; NaN where neither moved
    overlap_s: float

    def log_us(self, other_us: Times) -> Floats:
        """Return the other log's times on this log's axis."""
        return self.clock.log_us(self.other_clock.boot_us(other_us) + self.shift_us)

    def words(self) -> str:
        """Return how well it fits, for people."""
        fit = f"roll and pitch differ by {np.degrees(self.residual_rad):.2f} deg (rms)"
        moved = (
            f", correlation {self.correlation:.3f}"
            if np.isfinite(self.correlation)
            else "; hardly any motion to tell one time from another"
        )
        rate = self.clock.rate - self.other_clock.rate
        drift = f"; this log's clock runs {rate:+.3%} fast" if abs(rate) > TOLD_RATE else ""
        late = f"; telemetry up to {self.late_ms:.0f} ms late (95 %)"
        return f"aligned by {self.method}: over {self.overlap_s:.1f} s {fit}{moved}{drift}{late}"


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LoggedTilt:
    """Roll and pitch over time, of one boot."""

    time_us: Times  # of the log
    boot_us: Times
    tilt: Floats  # (n, 2) rad

    @property
    def clock(self) -> BootClockFit:
        """The log's time over the boot clock's."""
        return fit_boot_clock(self.time_us, self.boot_us)


def _tilts(flight: Flight) -> Iterator[LoggedTilt]:
    """Yield roll and pitch of each boot in the log."""
    table = flight.of_vehicle("ATTITUDE")
    boot_ms = table["time_boot_ms"].astype(np.int64)
    tilt = np.stack([table["roll"], table["pitch"]], axis=1).astype(np.float64)
    edges = [0, *(np.flatnonzero(np.diff(boot_ms) < -RESTART_MS) + 1).tolist(), len(table)]
    for start, stop in pairwise(edges):
        order = start + np.argsort(boot_ms[start:stop], kind="stable")
        if len(order):
            yield LoggedTilt(
                time_us=table.time_us[order], boot_us=boot_ms[order] * 1000, tilt=tilt[order]
            )


def _interpolated(times: Times, tilt: LoggedTilt, known_us: Times) -> Floats:
    x, known = times.astype(np.float64), known_us.astype(np.float64)
    parts = [np.interp(x, known, column, left=np.nan, right=np.nan) for column in tilt.tilt.T]
    return np.stack(parts, axis=1)


def _fit(method: str, shift_us: int, one: LoggedTilt, other: LoggedTilt) -> Alignment | None:
    """Return how well attitudes fit with the other's boot times shifted so."""
    there = _interpolated(one.boot_us, other, other.boot_us + shift_us)
    known = np.isfinite(there).all(axis=1)
    if not known.any():
        return None
    here, there = one.tilt[known], there[known]
    times = one.boot_us[known]
    moves = np.sqrt(np.square(here - here.mean(axis=0)).mean()) > MIN_TILT_RAD
    a, b = here - here.mean(axis=0), there - there.mean(axis=0)
    norm = float(np.sqrt(np.square(a).sum() * np.square(b).sum()))
    clock = one.clock
    return Alignment(
        method=method,
        clock=clock,
        other_clock=other.clock,
        shift_us=shift_us,
        late_ms=float(np.percentile(lateness_us(clock, one.time_us, one.boot_us), 95)) * 1e-3,
        residual_rad=float(np.sqrt(np.square(here - there).mean())),
        correlation=float((a * b).sum()) / norm if moves and norm > 0 else float("nan"),
        overlap_s=float(times[-1] - times[0]) * 1e-6,
    )


def by_boot_time(one: LoggedTilt, other: LoggedTilt) -> Alignment | None:
    """Return the alignment by the boot clock; None where the attitudes deny that it is one boot."""
    found = _fit("boot time", 0, one, other)
    if found is None or found.overlap_s < min(MIN_OVERLAP_S, _span_s(one), _span_s(other)):
        return None
    denied = found.residual_rad > MAX_RESIDUAL_RAD or found.correlation < MIN_CORRELATION
    return None if denied else found


def _span_s(tilt: LoggedTilt) -> float:
    return float(tilt.boot_us[-1] - tilt.boot_us[0]) * 1e-6


def _on_grid(tilt: LoggedTilt) -> Floats:
    """Return roll and pitch in even steps from the first boot time on, (n, 2), without means."""
    times = np.arange(tilt.boot_us[0], tilt.boot_us[-1] + 1, int(GRID_S * 1e6))
    values = np.nan_to_num(_interpolated(times, tilt, tilt.boot_us))
    centred: Floats = values - values.mean(axis=0)
    return centred


def correlation_by_shift(one: Floats, other: Floats) -> tuple[Floats, NDArray[np.int64]]:
    """Return the correlation (m,) of two series of steps (n, 2) for each shift of the other (m,).

    Each is normalised by what overlaps; an overlap below MIN_OVERLAP_S counts as 0.
    """
    correlate = load_library("scipy.signal", "logs").correlate
    shared = sum(correlate(a, b, method="fft") for a, b in zip(one.T, other.T, strict=True))
    ones, others = np.ones(len(one)), np.ones(len(other))
    energy = correlate(np.square(one).sum(axis=1), others, method="fft")
    energy_other = correlate(ones, np.square(other).sum(axis=1), method="fft")
    overlap = np.rint(correlate(ones, others, method="fft"))
    least = min(MIN_OVERLAP_S / GRID_S, len(one) - 1, len(other) - 1)
    norm = np.sqrt(np.maximum(energy, 0) * np.maximum(energy_other, 0))
    floor = 1e-6 * float(norm.max()) + 1e-12
    usable = (overlap >= least) & (norm > floor)
    found = np.where(usable, shared / np.where(usable, norm, 1.0), 0.0)
    return found, np.arange(len(found)) - (len(other) - 1)


def _peak_s(found: Floats, shifts: NDArray[np.int64]) -> float:
    """Return the shift of the largest correlation, between the steps by a parabola."""
    best = int(found.argmax())
    if not 0 < best < len(found) - 1:
        return float(shifts[best]) * GRID_S
    before, at, after = found[best - 1 : best + 2].tolist()
    bend = before - 2 * at + after
    return (float(shifts[best]) + (0.5 * (before - after) / bend if bend < 0 else 0.0)) * GRID_S


def by_attitude(one: LoggedTilt, other: LoggedTilt) -> Alignment | None:
    """Return the alignment at which the attitudes correlate best; None where they never fit."""
    if min(_span_s(one), _span_s(other)) < MIN_OVERLAP_S:
        return None
    found, shifts = correlation_by_shift(_on_grid(one), _on_grid(other))
    if found.max() < MIN_CORRELATION:
        return None
    shift_us = round(_peak_s(found, shifts) * 1e6) + int(one.boot_us[0] - other.boot_us[0])
    return _fit("attitude", shift_us, one, other)


def align(flight: Flight, other: Flight) -> Alignment:
    """Return how the other log's times become this one's; LogFileError where nothing fits."""
    names = f"{flight.log.name} and {other.log.name}"
    pairs = [(one, two) for one in _tilts(flight) for two in _tilts(other)]
    if not pairs:
        raise LogFileError(f"{names} cannot be aligned: one of them holds no attitude")
    for method in (by_boot_time, by_attitude):
        fits = [fit for pair in pairs if (fit := method(*pair)) is not None]
        if fits:
            return max(fits, key=lambda fit: fit.overlap_s)
    raise LogFileError(
        f"{names} do not look like one flight: their attitudes fit at no shift; check the files"
    )
