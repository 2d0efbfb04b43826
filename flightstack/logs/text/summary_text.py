"""Write a summary for people."""

import time
from collections.abc import Iterable, Iterator
from typing import Any

from flightstack.logs.facts.values import Facts

MAX_REGIONS = 5
MAX_TYPES = 12
MAX_TEXTS = 60
MARKS = {"error": "ERROR", "warning": "warn ", "ok": "ok   ", "skipped": "-    "}


def _number(value: float | None, unit: str, digits: int = 1) -> str:
    return "-" if value is None else f"{value:.{digits}f} {unit}".rstrip()


def duration(seconds: float) -> str:
    """Return a duration as people write it: 9.5 s, 2 min 03 s."""
    if seconds < 60:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    return f"{minutes} min {rest:02d} s"


def _head(facts: Facts) -> Iterator[str]:
    started = time.strftime("%Y-%m-%d %H:%M:%S", time.localtime(facts["start_unix_s"]))
    vehicle = facts["vehicle"]
    kind = f"{vehicle['kind']}, system {vehicle['system']}" if vehicle else "no autopilot"
    yield f"{facts['log']}: {kind}"
    yield f"  log       {started}, {duration(facts['duration_s'])}, {facts['messages']} messages"
    yield f"  ends      {facts['ends']}" + (", file cut off" if facts["damage"]["cut"] else "")


def _flight(facts: Facts) -> Iterator[str]:
    flights = f"{facts['flights']} flight" + ("s" if facts["flights"] != 1 else "")
    flown, armed = duration(facts["flight_time_s"]), duration(facts["armed_time_s"])
    yield f"  flight    {flights}, {flown} in the air, {armed} armed"
    if facts["flights"]:
        mean, top = (_number(facts[f"{which}_speed_m_s"], "m/s") for which in ("mean", "max"))
        climb, descent = (_number(facts[f"max_{way}_m_s"], "m/s") for way in ("climb", "descent"))
        yield (
            f"  motion    {_number(facts['distance_m'], 'm')} flown, speed {mean} (at most {top}), "
            f"height at most {_number(facts['max_height_m'], 'm')}, "
            f"climb at most {climb}, descent at most {descent}"
        )
    battery = facts["battery"]
    if battery:
        yield (
            f"  battery   {battery['start_v']:.2f} V ({battery['start_percent']} %) to "
            f"{battery['end_v']:.2f} V ({battery['end_percent']} %)"
        )


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
        if span["start_s"] + span["duration_s"] < facts["duration_s"]:
            events.append((span["start_s"] + span["duration_s"], "disarmed"))
    events += [(f["start_s"], f"failsafe: {f['state']}") for f in facts["failsafes"]]
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
        first, *others = row
        right = [cell.rjust(width) for cell, width in zip(others, widths[1:], strict=True)]
        yield "    " + "  ".join([first.ljust(widths[0]), *right])


def _links(facts: Facts) -> Iterator[str]:
    yield "  sources"
    head = ("source", "messages", "rate", "lost", "loss")
    rows = [
        (
            f"{link['system']}/{link['component']}",
            link["messages"],
            _number(link["rate_hz"], "Hz"),
            link["lost"],
            f"{link['loss_percent']:.2f} %",
        )
        for link in facts["links"]
    ]
    yield from _table([head, *rows])
    counts = list(facts["counts"].items())
    named = ", ".join(f"{name} {count}" for name, count in counts[:MAX_TYPES])
    more = f", {len(counts) - MAX_TYPES} more types" if len(counts) > MAX_TYPES else ""
    yield f"  messages  {named}{more}"


def _damage(facts: Facts) -> Iterator[str]:
    regions = facts["damage"]["regions"]
    if not regions:
        return
    yield f"  damage    {facts['damage']['lost_bytes']} bytes in {len(regions)} places"
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
    flown = duration(facts["flight_time_s"])
    return (
        f"{facts['log']}: {facts['messages']} messages, {flown} flown{gates}, {facts['ends']}"
        + (f" [{', '.join(worst)}]" if worst else "")
    )
