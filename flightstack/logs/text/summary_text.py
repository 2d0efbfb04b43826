"""Write a summary for people."""

import time
from collections.abc import Iterable, Iterator
from typing import Any

from flightstack.logs.facts.values import Facts
from flightstack.printable import printable

SET_AFTER_S = 1e9  # 2001: an earlier time is of a clock that was never set
MAX_REGIONS = 5
MAX_TYPES = 12
MAX_TEXTS = 60
MARKS = {"error": "ERROR", "warning": "warn ", "ok": "ok   ", "skipped": "-    "}


def _number(value: float | None, unit: str, digits: int = 1) -> str:
    return "-" if value is None else f"{round(value, digits) + 0.0:.{digits}f} {unit}".rstrip()


def duration(seconds: float) -> str:
    """Return a duration as people write it: 9.5 s, 2 min 03 s."""
    if seconds < 60:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest:02d} s"


def _head(facts: Facts) -> Iterator[str]:
    vehicle = facts["vehicle"]
    kind = f"{vehicle['kind']}, system {vehicle['system']}" if vehicle else "no autopilot"
    yield f"{printable(facts['log'])}: {kind}"
    for other in facts["other_vehicles"]:
        yield f"  also      system {other['system']}: {other['kind']} (--system {other['system']})"
    about = f"{duration(facts['duration_s'])}, {facts['messages']} messages"
    yield f"  log       {started(facts['start_unix_s'])}, {about}"
    yield f"  ends      {facts['ends']}" + (", file cut off" if facts["damage"]["cut"] else "")


def started(unix_s: float) -> str:
    """Return when a log starts; what no clock was set for is said to be so."""
    if unix_s < SET_AFTER_S:
        return f"at {unix_s:.1f} s after boot, by a clock that was not set"
    return time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(unix_s))


def counted(count: int, noun: str) -> str:
    """Return a number of things: 1 flight, 2 flights."""
    return f"{count} {noun}" + ("s" if count != 1 else "")


def charge(battery: Facts, when: str) -> str:
    """Return voltage and charge of a battery at the "start" or the "end", as far as known."""
    volts, percent = battery[f"{when}_v"], battery[f"{when}_percent"]
    parts = [] if volts is None else [f"{volts:.2f} V"]
    if percent is not None:
        parts.append(f"({percent} %)" if parts else f"{percent} %")
    return " ".join(parts)


def _height(facts: Facts) -> str:
    if facts["max_depth_m"] is not None:
        return f"depth at most {_number(facts['max_depth_m'], 'm')}"
    return f"height at most {_number(facts['max_height_m'], 'm')}"


def _flight(facts: Facts) -> Iterator[str]:
    outings = counted(facts["outings"], facts["outing"])
    under_way, armed = duration(facts["outing_time_s"]), duration(facts["armed_time_s"])
    said = f"{outings}, {under_way} {facts['under_way']}, {armed} armed"
    if not facts["tells_armed"]:
        said = "not told: nothing says when it was armed"
    yield f"  {facts['outing']:9} {said}"
    if facts["outings"]:
        mean, top = (_number(facts[f"{which}_speed_m_s"], "m/s") for which in ("mean", "max"))
        climb, descent = (_number(facts[f"max_{way}_m_s"], "m/s") for way in ("climb", "descent"))
        yield (
            f"  motion    {_number(facts['distance_m'], 'm')}, speed {mean} (at most {top}), "
            f"{_height(facts)}, climb at most {climb}, descent at most {descent}"
        )
    elif facts["position_from"]:
        yield f"  motion    position from {facts['position_from']}"
    battery = facts["battery"]
    if battery:
        yield f"  battery   {charge(battery, 'start')} to {charge(battery, 'end')}"
    if facts["gps"]:
        yield f"  GPS       {gps_said(facts['gps'])}"


def gps_said(gps: Facts) -> str:
    """Return how well a GPS saw the sky: 3D fix, 7 to 12 satellites, HDOP 0.8 to 1.4."""
    parts = [str(gps["fix"])]
    if gps["max_satellites"] is not None:
        parts.append(f"{gps['min_satellites']} to {gps['max_satellites']} satellites")
    if gps["worst_hdop"] is not None:
        parts.append(f"HDOP {gps['best_hdop']:.1f} to {gps['worst_hdop']:.1f}")
    return ", ".join(parts)


def _course(facts: Facts) -> Iterator[str]:
    course = facts["course"]
    if course:
        text = f": {course['text']}" if course["text"] else ""
        yield f"  course    {course['gates_passed']} gates passed, {course['ended']}{text}"
    offboard = facts["offboard"]
    if not offboard:
        return
    yield (
        f"  offboard  {duration(offboard['duration_s'])}, {offboard['setpoints']} setpoints at "
        f"{_number(offboard['rate_hz'], 'Hz')}, "
        f"longest gap {_number(offboard['longest_gap_s'], 's', 2)}"
    )
    if offboard["frames"]:
        late = offboard["frame_to_setpoint_ms"]
        yield (
            f"  frames    {offboard['frames_answered']} of {offboard['frames']} answered, frame to "
            f"setpoint {_number(late['p50'], 'ms')} (95 % within {_number(late['p95'], 'ms')}, "
            f"at most {_number(late['max'], 'ms')})"
        )
    ages = offboard["frame_age_ms"]
    if ages["max"]:
        yield (
            f"  ages      frames were {_number(ages['p50'], 'ms')} old when they were received "
            f"(95 % within {_number(ages['p95'], 'ms')})"
        )
    lags, errors = offboard["setpoint_to_response_s"], offboard["tracking_rms"]
    yield "  response  " + ", ".join(
        f"{name} lag {_number(lag, 's', 2)} rms {_number(errors[name], '', 2)}"
        for name, lag in lags.items()
    )


def _timeline(facts: Facts) -> Iterator[str]:
    events: list[tuple[float, str]] = []
    events += [(m["start_s"], f"mode {m['mode']}") for m in facts["modes"]]
    for span in facts["armed"]:
        events.append((span["start_s"], "armed"))
        if not span["to_the_end"]:
            events.append((span["start_s"] + span["duration_s"], "disarmed"))
    events += [(f["start_s"], f"failsafe: {f['state']}") for f in facts["failsafes"]]
    events += [(r["at_s"], "the autopilot started again") for r in facts["restarts"]]
    texts = facts["texts"][:MAX_TEXTS]
    events += [(t["at_s"], f"{t['source']} {t['level']}: {t['text']}") for t in texts]
    yield "  timeline"
    for at_s, what in sorted(events, key=lambda event: event[0]):
        yield f"    {at_s:9.2f} s  {what}"
    if len(facts["texts"]) > MAX_TEXTS:
        yield f"    ... {len(facts['texts']) - MAX_TEXTS} more texts: see the command texts"


def _table(rows: Iterable[tuple[Any, ...]]) -> Iterator[str]:
    cells = [[str(cell) for cell in row] for row in rows]
    widths = [max(map(len, column)) for column in zip(*cells, strict=True)]
    for row in cells:
        first, *others, last = row
        right = [cell.rjust(width) for cell, width in zip(others, widths[1:-1], strict=True)]
        yield "    " + "  ".join([first.ljust(widths[0]), *right, last])


def _links(facts: Facts) -> Iterator[str]:
    yield "  sources"
    head = ("source", "messages", "rate", "lost", "loss", "what")
    rows = [
        (
            f"{link['system']}/{link['component']}",
            link["messages"],
            _number(link["rate_hz"], "Hz"),
            "-" if link["lost"] is None else link["lost"],
            _number(link["loss_percent"], "%", 2),
            link["role"],
        )
        for link in facts["links"]
    ]
    yield from _table([head, *rows])
    for link in facts["links"]:
        if link["counted"]:
            yield f"    {link['system']}/{link['component']}: {link['counted']}"
    counts = list(facts["counts"].items())
    named = ", ".join(f"{name} {count}" for name, count in counts[:MAX_TYPES])
    more = f", {len(counts) - MAX_TYPES} more types" if len(counts) > MAX_TYPES else ""
    yield f"  messages  {named}{more}"


def _damage(facts: Facts) -> Iterator[str]:
    regions = facts["damage"]["regions"]
    if facts["damage"]["line_ends"]:
        yield f"  file      {facts['damage']['line_ends']}"
    if not regions:
        return
    places = counted(len(regions), "place")
    yield f"  damage    {facts['damage']['lost_bytes']} bytes in {places}"
    for region in regions[:MAX_REGIONS]:
        yield (
            f"    {region['bytes']} bytes at {region['offset']} ({region['kind']}), "
            f"after {region['at_s']:.2f} s"
        )
    if len(regions) > MAX_REGIONS:
        yield f"    ... {len(regions) - MAX_REGIONS} more"


def check_lines(findings: Iterable[dict[str, str]]) -> Iterator[str]:
    """Yield one line a check."""
    for finding in findings:
        yield f"    {MARKS[finding['level']]}  {finding['name']}: {finding['reason']}"


def page(facts: Facts) -> str:
    """Return the summary as a page of text."""
    parts = (_head, _flight, _course, _timeline, _links, _damage)
    lines = [line for part in parts for line in part(facts)]
    shown = [finding for finding in facts["checks"] if finding["level"] != "skipped"]
    return "\n".join([*lines, "  checks", *check_lines(shown)])


def one_line(facts: Facts) -> str:
    """Return the summary of one log among many."""
    worst = [c["name"] for c in facts["checks"] if c["level"] in ("error", "warning")]
    course = facts["course"]
    gates = f", {course['gates_passed']} gates, {course['ended']}" if course else ""
    flown = f"{duration(facts['outing_time_s'])} {facts['under_way']}"
    return (
        f"{printable(facts['log'])}: {facts['messages']} messages, {flown}{gates}, {facts['ends']}"
        + (f" [{', '.join(worst)}]" if worst else "")
    )
