"""Find when a vehicle was under way: flights, drives or dives, by what it is and what it told.

Where the autopilot tells its landed state, flights are by that. Else by height, depth or speed
while armed, with a lower limit to end than to begin, both above the noise of the estimate.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.columns.table import Table
from flightstack.logs.flight.motion import Motion
from flightstack.logs.flight.vehicle import Interval, LoggedVehicle, intervals

ALOFT = (2, 3, 4)  # MAV_LANDED_STATE: in the air, taking off, landing
REST_S = 2.0  # a shorter stop is part of what goes on
MIN_OUTING_S = 2.0  # a shorter one, where none is told, is noise
SMOOTH_S = 1.0  # noise is taken out over this long
MAX_SMOOTHED = 25  # samples
NOISE_SIGMAS = 4.0
REFERENCE_S = 2.0  # before arming, or soon after: there the height is zero

Floats = NDArray[np.float64]
Labels = NDArray[np.bool_]


class OutingKind(NamedTuple):
    """What being under way is called, and from which measure on a vehicle is."""

    noun: str
    under_way: str  # of the vehicle, for people
    at_rest: str
    done: str
    never: str
    limit: float  # m of height or depth, m/s of speed
    by_speed: bool = False
    is_down: bool = False  # depth rather than height


FLIGHT = OutingKind("flight", "in the air", "on the ground", "landed", "never flew", 0.5)
PLANE_FLIGHT = FLIGHT._replace(limit=3.0)
DRIVE = OutingKind("drive", "driving", "standing", "stopped", "never drove", 0.5, by_speed=True)
TRIP = DRIVE._replace(noun="trip", under_way="under way", at_rest="lying still", never="never left")
DIVE = OutingKind(
    "dive", "submerged", "at the surface", "surfaced", "never dived", 0.5, is_down=True
)
KINDS = {  # MAV_TYPE
    1: PLANE_FLIGHT,
    10: DRIVE,
    11: TRIP,
    12: DIVE,
}


def kind_of(vehicle: LoggedVehicle | None) -> OutingKind:
    """Return what this vehicle does when it is under way."""
    return FLIGHT if vehicle is None else KINDS.get(vehicle.type, FLIGHT)


def _smoothed(values: Floats, count: int) -> Floats:
    """Return the running median over so many values, an odd number."""
    half = count // 2
    if half < 1 or len(values) <= count:
        return values
    padded = np.pad(values, half, mode="edge")
    windows = np.lib.stride_tricks.sliding_window_view(padded, 2 * half + 1)
    return np.asarray(np.median(windows, axis=1), dtype=np.float64)


def _noise(measure: Floats, rate: Floats, step_s: Floats) -> float:
    """Return the standard deviation of steps that the rate of change does not explain."""
    if len(measure) < 3:
        return 0.0
    unexplained = np.diff(measure) - (rate[1:] + rate[:-1]) / 2 * step_s
    return float(1.4826 * np.median(np.abs(unexplained)) / np.sqrt(2))


def _latched(measure: Floats, start: float, end: float) -> Labels:
    """Return where the measure has risen above `start` and not yet fallen below `end`."""
    code = np.where(measure > start, 1, np.where(measure < end, 0, -1))
    code[0] = max(code[0], 0)
    known = np.maximum.accumulate(np.where(code >= 0, np.arange(len(code)), 0))
    return np.asarray(code[known] == 1, dtype=np.bool_)


def _measure(part: Motion, kind: OutingKind) -> tuple[Floats, Floats]:
    """Return height, depth or speed, and its rate of change as far as the vehicle tells it."""
    if kind.by_speed:
        return part.horizontal_speed_m_s, np.zeros(len(part))
    sign = 1.0 if kind.is_down else -1.0
    return sign * part.position_ned[:, 2], sign * part.velocity_ned[:, 2]


def _reference(motion: Motion, kind: OutingKind, armed: Interval) -> float:
    """Return the height or depth at which the vehicle was armed; the origin's if untold."""
    if kind.by_speed or armed.is_from_start:
        return 0.0
    before = motion.within(round(armed.start_us - REFERENCE_S * 1e6), armed.start_us + 1)
    if not len(before):
        soon = motion.within(armed.start_us, round(armed.start_us + REFERENCE_S * 1e6))
        before = soon.take(soon.time_us == soon.time_us[:1])
    if not len(before):
        return 0.0
    return float(np.median(_measure(before, kind)[0]))


def _joined(spans: list[Interval], rest_s: float) -> list[Interval]:
    """Return spans with short rests between them filled, and short spans left out."""
    joined: list[Interval] = []
    for span in spans:
        if joined and (span.start_us - joined[-1].end_us) * 1e-6 < rest_s:
            joined[-1] = joined[-1].until(span.end_us, is_open=span.is_open)
        else:
            joined.append(span)
    return joined


def _while_armed(motion: Motion, kind: OutingKind, armed: Interval) -> list[Interval]:
    part = motion.within(armed.start_us, armed.end_us)
    if not len(part):
        return [armed.called(kind.noun)]
    measure, rate = _measure(part, kind)
    measure = measure - _reference(motion, kind, armed)
    step_s = np.diff(part.measured_us) * 1e-6
    typical_s = float(np.median(step_s)) if len(step_s) else SMOOTH_S
    count = min(int(SMOOTH_S / max(typical_s, 1e-3)), MAX_SMOOTHED)
    start = kind.limit
    if not kind.by_speed:
        start += NOISE_SIGMAS * _noise(measure, rate, step_s)
    moving = _latched(_smoothed(measure, count), start, start / 2)
    labels = np.where(moving, kind.noun, "").tolist()
    spans = intervals(part.time_us, labels, armed.end_us, is_open=armed.is_open)
    joined = _joined([span for span in spans if span.label], REST_S)
    return [span for span in joined if span.is_open or span.duration_s >= MIN_OUTING_S]


def find_outings(
    kind: OutingKind, motion: Motion, armed: list[Interval], states: Table, end_us: int
) -> list[Interval]:
    """Return when the vehicle was under way; `states` tell whether it has landed."""
    told = states["landed_state"]
    if len(states) and told.any() and not (kind.by_speed or kind.is_down):
        labels = np.where(np.isin(told, ALOFT), kind.noun, "").tolist()
        return [span for span in intervals(states.time_us, labels, end_us) if span.label]
    return [span for each in armed for span in _while_armed(motion, kind, each)]
