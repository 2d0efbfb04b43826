"""Tell a flight in a few sentences, and in tiles of one figure each."""

from collections.abc import Iterator

from flightstack.logs.facts.values import Facts
from flightstack.logs.text.summary_text import charge, counted, duration

Tile = tuple[str, str]  # a figure, and what it is


def story(facts: Facts) -> str:
    """Return the flight in one or two sentences."""
    if not facts["vehicle"]:
        return f"No autopilot speaks in this log of {facts['messages']} messages."
    outings = counted(facts["outings"], facts["outing"])
    if not facts["outings"]:
        return f"No {facts['outing']} in this log, which covers {duration(facts['duration_s'])}."
    distance, under_way_s = facts["distance_m"] or 0.0, duration(facts["outing_time_s"])
    flown = f"{outings[0].upper()}{outings[1:]} of {distance:.0f} m in {under_way_s}"
    speed = facts["max_speed_m_s"]
    parts = [flown + (f", at up to {speed:.1f} m/s." if speed is not None else ".")]
    course = facts["course"]
    if course:
        end = f"; {course['text'][0].lower()}{course['text'][1:]}" if course["text"] else ""
        gates = "gate" if course["gates_passed"] == 1 else "gates"
        parts.append(f"Passed {course['gates_passed']} {gates}{end}.")
    if facts["failsafes"]:
        parts.append(f"In failsafe {counted(len(facts['failsafes']), 'time')}.")
    if facts["restarts"]:
        parts.append(f"The autopilot started again {counted(len(facts['restarts']), 'time')}.")
    parts += [
        f"Also in the log: system {other['system']}, {other['kind']}."
        for other in facts["other_vehicles"]
    ]
    parts.append(f"At the end: {facts['ends']}.")
    return " ".join(parts)


def _outing(facts: Facts) -> Iterator[Tile]:
    if facts["tells_armed"]:
        yield duration(facts["outing_time_s"]), facts["under_way"]
        yield duration(facts["armed_at_rest_s"]), f"armed {facts['at_rest']}"
    if facts["distance_m"]:
        yield f"{facts['distance_m']:.0f} m", "covered"
    if facts["max_depth_m"] is not None:
        yield f"{facts['max_depth_m']:.1f} m", "deepest"
    elif facts["max_height_m"] is not None and facts["outing"] == "flight":
        yield f"{facts['max_height_m']:.1f} m", "highest"
    if facts["max_speed_m_s"] is not None:
        yield f"{facts['max_speed_m_s']:.1f} m/s", "top speed"


def _companion(facts: Facts) -> Iterator[Tile]:
    if facts["course"]:
        yield str(facts["course"]["gates_passed"]), "gates passed"
    offboard = facts["offboard"]
    if not offboard:
        return
    if offboard["rate_hz"]:
        yield f"{offboard['rate_hz']:.1f} Hz", "setpoints"
    if offboard["frames"]:
        yield f"{offboard['frames_answered'] / offboard['frames']:.1%}", "frames answered"
    late = offboard["frame_to_setpoint_ms"]["p95"]
    if late is not None:
        yield f"{late:.0f} ms", "frame to setpoint (95 %)"


def _health(facts: Facts) -> Iterator[Tile]:
    losses = [link["loss_percent"] for link in facts["links"] if link["loss_percent"] is not None]
    if losses:
        yield f"{max(losses):.2f} %", "worst link loss"
    if facts["battery"]:
        yield charge(facts["battery"], "end"), "battery at the end"
    gps = facts["gps"]
    if gps and gps["min_satellites"] is not None:
        yield f"{gps['min_satellites']}", f"satellites at the least, {gps['fix']}"
    if facts["restarts"]:
        yield str(len(facts["restarts"])), "restarts of the autopilot"


def tiles(facts: Facts) -> Iterator[Tile]:
    """Yield the figures that the log has."""
    yield from _outing(facts)
    yield from _companion(facts)
    yield from _health(facts)
