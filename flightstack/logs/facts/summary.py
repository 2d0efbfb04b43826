"""Say in a second what a log holds: flight, modes, texts, battery, link, offboard, its end."""

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.checks.registry import Finding
from flightstack.logs.columns.senders import Participant
from flightstack.logs.facts.values import Facts, rate_hz, rounded
from flightstack.logs.flight.decisions import VELOCITIES
from flightstack.logs.flight.flight import Flight
from flightstack.logs.flight.vehicle import Interval, vehicle_of
from flightstack.logs.tlog.losses import EXPLANATIONS

MIN_FLIGHT_S = 0.5


def _span_facts(flight: Flight, spans: list[Interval], name: str) -> list[Facts]:
    return [
        {
            name: span.label,
            "start_s": rounded(flight.seconds(span.start_us)),
            "duration_s": rounded(span.duration_s),
            "to_the_end": span.is_open,
        }
        for span in spans
    ]


def flight_facts(flight: Flight) -> Facts:
    """Return how often and how long the vehicle was under way, distance and speeds."""
    kind = flight.outing_kind
    spans = [span for span in flight.outings if span.duration_s >= MIN_FLIGHT_S]
    parts = [flight.motion.within(span.start_us, span.end_us) for span in spans]
    filled = [part for part in parts if len(part)]
    speeds = [part.horizontal_speed_m_s for part in filled]
    downs = [part.velocity_ned[:, 2] for part in filled]
    heights = [-part.position_ned[:, 2] for part in filled]
    depths = [part.position_ned[:, 2].max() for part in filled] if kind.is_down else []
    under_way_s = sum(span.duration_s for span in spans)
    armed_s = sum(span.duration_s for span in flight.armed)
    flights = len(spans) if kind.noun == "flight" else 0
    return {
        "flights": flights,
        "flight_time_s": rounded(under_way_s if flights else 0.0),
        "tells_armed": flight.states.tells_armed,
        "outing": kind.noun,
        "under_way": kind.under_way,
        "at_rest": kind.at_rest,
        "outings": len(spans),
        "outing_time_s": rounded(under_way_s),
        "armed_time_s": rounded(armed_s),
        "armed_at_rest_s": rounded(max(armed_s - under_way_s, 0.0)),
        "distance_m": rounded(sum(part.distance_m() for part in filled), 1),
        "max_speed_m_s": rounded(max((s.max() for s in speeds), default=None)),
        "mean_speed_m_s": rounded(np.concatenate(speeds).mean() if speeds else None),
        "max_climb_m_s": rounded(max((max(-d.min(), 0.0) for d in downs), default=None)),
        "max_descent_m_s": rounded(max((max(d.max(), 0.0) for d in downs), default=None)),
        "max_height_m": rounded(max((h.max() for h in heights), default=None)),
        "max_depth_m": rounded(max(depths, default=None)),
        "position_from": flight.motion.source if len(flight.motion) else None,
    }


def battery_facts(flight: Flight) -> Facts | None:
    """Return voltage and charge at both ends of the log; None where nothing was reported."""
    battery = flight.battery
    if not len(battery):
        return None
    volts, percent = battery.volts, battery.percent.tolist()
    return {
        "start_v": rounded(volts[0] if len(volts) else None),
        "end_v": rounded(volts[-1] if len(volts) else None),
        "min_v": rounded(volts.min() if len(volts) else None),
        "start_percent": percent[0] if percent else None,
        "end_percent": percent[-1] if percent else None,
    }


def gps_facts(flight: Flight) -> Facts | None:
    """Return how well the GPS saw the sky; None where nothing was told."""
    gps = flight.gps
    if not len(gps):
        return None
    satellites, hdop = gps.satellites[gps.satellites >= 0], gps.hdop[gps.hdop >= 0]
    return {
        "fix": gps.usual_fix,
        "min_satellites": int(satellites.min()) if len(satellites) else None,
        "max_satellites": int(satellites.max()) if len(satellites) else None,
        "best_hdop": rounded(hdop.min() if len(hdop) else None, 2),
        "worst_hdop": rounded(hdop.max() if len(hdop) else None, 2),
    }


def link_facts(flight: Flight) -> list[Facts]:
    """Return for every sender what it is, its messages, rate and loss."""
    log = flight.log
    roles = {(each.system, each.component): each.role for each in flight.participants}
    facts = []
    for loss in log.losses:
        times = log.time_us[log.packets.sender == (loss.system << 8 | loss.component)]
        duration_s = float(times.max() - times.min()) * 1e-6
        facts.append(
            {
                "system": loss.system,
                "component": loss.component,
                "role": roles[loss.system, loss.component],
                "messages": loss.received,
                "rate_hz": rate_hz(loss.received, duration_s),
                "lost": loss.lost if loss.is_clear else None,
                "loss_percent": rounded(100 * loss.fraction, 3) if loss.is_clear else None,
                "reordered": loss.reordered,
                "counted": EXPLANATIONS[loss.counted],
            }
        )
    return facts


def vehicle_facts(participant: Participant | None) -> Facts | None:
    """Return who a vehicle is; None without one."""
    vehicle = vehicle_of(participant)
    if vehicle is None:
        return None
    return {"system": vehicle.system, "component": vehicle.component, "kind": vehicle.kind}


def _percentiles(values: NDArray[np.float64]) -> Facts:
    known = values[np.isfinite(values)]
    if not len(known):
        return {"p50": None, "p95": None, "max": None}
    p50, p95 = np.percentile(known, (50, 95))
    return {"p50": rounded(p50), "p95": rounded(p95), "max": rounded(known.max())}


def offboard_facts(flight: Flight) -> Facts | None:
    """Return how well the companion kept up; None where none streamed setpoints."""
    times = flight.offboard_setpoint_times
    if not flight.offboard or not (len(times) or len(flight.decisions)):
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
        "frame_age_ms": _percentiles(1e3 * flight.decisions.image_age_s),
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
        "line_ends": damage.line_ends,
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
    return {
        "log": flight.log.name,
        "start_unix_s": rounded(flight.start_us * 1e-6),
        "duration_s": rounded((flight.end_us - flight.start_us) * 1e-6),
        "messages": len(flight.log),
        "vehicle": vehicle_facts(flight.autopilot),
        "other_vehicles": [vehicle_facts(each) for each in flight.other_vehicles],
        **flight_facts(flight),
        "ends": flight.ending,
        "armed": _span_facts(flight, flight.armed, "state"),
        "modes": _span_facts(flight, flight.modes, "mode"),
        "restarts": [{"at_s": rounded(flight.seconds(at_us))} for at_us in flight.restarts],
        "failsafes": _span_facts(flight, flight.failsafes, "state"),
        "course": course_facts(flight),
        "offboard": offboard_facts(flight),
        "battery": battery_facts(flight),
        "gps": gps_facts(flight),
        "links": link_facts(flight),
        "counts": flight.log.counts,
        "texts": text_facts(flight),
        "damage": damage_facts(flight),
        "checks": [finding.as_facts() for finding in findings],
    }
