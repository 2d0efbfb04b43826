"""Say in a second what a log holds: flight, modes, texts, battery, link, offboard, its end."""

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.checks.registry import Finding
from flightstack.logs.facts.values import Facts, rounded
from flightstack.logs.flight.decisions import VELOCITIES
from flightstack.logs.flight.flight import Flight
from flightstack.logs.flight.vehicle import Interval

MIN_FLIGHT_S = 0.5
UNKNOWN_REMAINING = -1


def _span_facts(flight: Flight, spans: list[Interval], name: str) -> list[Facts]:
    return [
        {
            name: span.label,
            "start_s": rounded(flight.seconds(span.start_us)),
            "duration_s": rounded(span.duration_s),
        }
        for span in spans
    ]


def flight_facts(flight: Flight) -> Facts:
    """Return flight time, distance and speeds."""
    spans = [span for span in flight.flying if span.duration_s >= MIN_FLIGHT_S]
    parts = [flight.motion.within(span.start_us, span.end_us) for span in spans]
    filled = [part for part in parts if len(part)]
    speeds = [part.horizontal_speed_m_s for part in filled]
    downs = [part.velocity_ned[:, 2] for part in filled]
    heights = [-part.position_ned[:, 2] for part in filled]
    return {
        "flights": len(spans),
        "flight_time_s": rounded(sum(span.duration_s for span in spans)),
        "armed_time_s": rounded(sum(span.duration_s for span in flight.armed)),
        "distance_m": rounded(sum(part.distance_m() for part in filled), 1),
        "max_speed_m_s": rounded(max((s.max() for s in speeds), default=None)),
        "mean_speed_m_s": rounded(np.concatenate(speeds).mean() if speeds else None),
        "max_climb_m_s": rounded(max((-d.min() for d in downs), default=None)),
        "max_descent_m_s": rounded(max((d.max() for d in downs), default=None)),
        "max_height_m": rounded(max((h.max() for h in heights), default=None)),
        "position_from": flight.motion.source if len(flight.motion) else None,
    }


def battery_facts(flight: Flight) -> Facts | None:
    """Return voltage and charge at both ends of the log; None where nothing was reported."""
    table = flight.battery
    if not len(table):
        return None
    volts = table["voltage_battery"] * 1e-3
    remaining = table["battery_remaining"]
    known = remaining[remaining != UNKNOWN_REMAINING]
    return {
        "start_v": rounded(volts[0]),
        "end_v": rounded(volts[-1]),
        "min_v": rounded(volts.min()),
        "start_percent": int(known[0]) if len(known) else None,
        "end_percent": int(known[-1]) if len(known) else None,
    }


def link_facts(flight: Flight) -> list[Facts]:
    """Return for every sender its messages, rate and loss."""
    log = flight.log
    facts = []
    for loss in log.losses:
        times = log.time_us[log.packets.sender == (loss.system << 8 | loss.component)]
        duration_s = float(times.max() - times.min()) * 1e-6
        facts.append(
            {
                "system": loss.system,
                "component": loss.component,
                "messages": loss.received,
                "rate_hz": rounded((loss.received - 1) / duration_s if duration_s else None, 2),
                "lost": loss.lost,
                "loss_percent": rounded(100 * loss.fraction, 3),
                "reordered": loss.reordered,
            }
        )
    return facts


def _percentiles(values: NDArray[np.float64]) -> Facts:
    known = values[np.isfinite(values)]
    if not len(known):
        return {"p50": None, "p95": None, "max": None}
    p50, p95 = np.percentile(known, (50, 95))
    return {"p50": rounded(p50), "p95": rounded(p95), "max": rounded(known.max())}


def offboard_facts(flight: Flight) -> Facts | None:
    """Return how well the companion kept up; None where nothing was flown OFFBOARD."""
    times = flight.offboard_setpoint_times
    if not flight.offboard:
        return None
    steps_s = np.diff(times) * 1e-6
    duration_s = sum(span.duration_s for span in flight.offboard)
    lags = flight.response_lags_s
    errors = flight.tracking.rms_error().tolist()
    return {
        "duration_s": rounded(duration_s),
        "entries": len(flight.offboard),
        "setpoints": len(times),
        "rate_hz": rounded(len(times) / duration_s if duration_s else None, 2),
        "longest_gap_s": rounded(steps_s.max() if len(steps_s) else None),
        "frames": flight.answers.images,
        "frames_answered": flight.answers.answered,
        "frame_to_setpoint_ms": _percentiles(flight.answers.latency_ms),
        "setpoint_to_response_s": dict(zip(VELOCITIES, map(rounded, lags), strict=True)),
        "tracking_rms": dict(zip(VELOCITIES, map(rounded, errors), strict=True)),
        "decisions": len(flight.decisions),
    }


def course_facts(flight: Flight) -> Facts | None:
    """Return what the referee said; None without one."""
    events = flight.course_events
    if not events and not flight.gates_passed:
        return None
    ending = next((e for e in events if e.is_failure or e.kind == "finished"), None)
    return {
        "gates_passed": flight.gates_passed,
        "ended": ending.kind if ending else "open",
        "text": ending.text if ending else None,
    }


def text_facts(flight: Flight) -> list[Facts]:
    """Return every status text with its time and source."""
    return [
        {
            "at_s": rounded(flight.seconds(text.time_us)),
            "source": text.source,
            "level": text.level,
            "text": text.text,
        }
        for text in flight.texts
    ]


def damage_facts(flight: Flight) -> Facts:
    """Return what the file has lost, and where."""
    damage = flight.log.damage
    return {
        "lost_bytes": damage.lost_bytes,
        "cut": damage.is_cut,
        "has_times": damage.has_times,
        "mended_times": damage.mended_times,
        "duplicates": damage.duplicates,
        "clock_jumps": [
            {"at_s": rounded(flight.seconds(j.time_us)), "jump_s": rounded(j.jump_us * 1e-6)}
            for j in damage.jumps
        ],
        "regions": [
            {
                "offset": region.offset,
                "bytes": region.length,
                "at_s": rounded(flight.seconds(region.time_us)),
                "kind": region.kind,
            }
            for region in damage.regions
        ],
    }


def summarise(flight: Flight, findings: list[Finding]) -> Facts:
    """Return all facts of a flight as plain values, ready for JSON."""
    vehicle = flight.vehicle
    return {
        "log": flight.log.name,
        "start_unix_s": rounded(flight.start_us * 1e-6),
        "duration_s": rounded((flight.end_us - flight.start_us) * 1e-6),
        "messages": len(flight.log),
        "vehicle": None
        if vehicle is None
        else {"system": vehicle.system, "component": vehicle.component, "kind": vehicle.kind},
        **flight_facts(flight),
        "ends": flight.ending,
        "armed": _span_facts(flight, flight.armed, "state"),
        "modes": _span_facts(flight, flight.modes, "mode"),
        "failsafes": _span_facts(flight, flight.failsafes, "state"),
        "course": course_facts(flight),
        "offboard": offboard_facts(flight),
        "battery": battery_facts(flight),
        "links": link_facts(flight),
        "counts": flight.log.counts,
        "texts": text_facts(flight),
        "damage": damage_facts(flight),
        "checks": [finding.as_facts() for finding in findings],
    }
