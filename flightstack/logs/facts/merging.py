"""Join the facts of a log's parts: sums, extremes, lists one behind the other.

What a number means stands in its name: max_ and longest_ are the largest, min_ the least, start_
is of the first part and end_ of the last, mean_ and what is measured setpoint by setpoint are
averages; all else counts, and is added.
"""

import math
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

from flightstack.logs.facts.values import Facts

SHIFTED = ("at_s", "start_s", "first_s", "last_s")  # seconds since the start of the log
SPANS = ("armed", "modes", "failsafes")
LEVELS = ("error", "warning", "ok", "skipped")  # worst first
FIRST = ("log", "start_unix_s", "vehicle", "position_from", "system", "component")
ALL = ("has_times",)
SAME_SPAN_S = 3.0  # HEARTBEATs come each second: a span ends in one part and goes on in the next
SQUARED = ("tracking_rms",)


def _average(one: float | None, other: float | None, weights: tuple[float, float]) -> float | None:
    """Return the average of what is known."""
    pairs = [(v, w) for v, w in zip((one, other), weights, strict=True) if v is not None]
    total = sum(weight for _, weight in pairs)
    if not total:
        return pairs[0][0] if pairs else None
    return round(sum(value * weight for value, weight in pairs) / total, 3)


def _rms(one: float | None, other: float | None, weights: tuple[float, float]) -> float | None:
    squares = [None if value is None else value * value for value in (one, other)]
    mean = _average(squares[0], squares[1], weights)
    return None if mean is None else round(math.sqrt(mean), 3)


def _shifted(rows: list[Facts], shift_s: float, offset: int) -> list[Facts]:
    """Return rows with their times and places in the whole log."""
    moved = []
    for row in rows:
        times = {key: round(row[key] + shift_s, 3) for key in SHIFTED if row.get(key) is not None}
        place = {"offset": row["offset"] + offset} if "offset" in row else {}
        moved.append({**row, **times, **place})
    return moved


def _joined_spans(one: list[Facts], other: list[Facts], *, goes_on: bool) -> list[Facts]:
    """Return spans of both parts; one that goes on in the next part is one.

    With `goes_on` each span lasts until the next begins, as a mode does.
    """
    if not one or not other:
        return [*one, *other]
    last, first = one[-1], other[0]
    label = last.keys() - {"start_s", "duration_s", "to_the_end"}
    gap_s = first["start_s"] - last["start_s"] - last["duration_s"]
    if all(last[key] == first.get(key) for key in label) and gap_s <= SAME_SPAN_S:
        duration_s = first["start_s"] + first["duration_s"] - last["start_s"]
        joined = {**first, "start_s": last["start_s"], "duration_s": round(duration_s, 3)}
        return [*one[:-1], joined, *other[1:]]
    if last.get("to_the_end"):
        until_s = first["start_s"] - last["start_s"] if goes_on else last["duration_s"]
        last = {**last, "duration_s": round(until_s, 3), "to_the_end": False}
    return [*one[:-1], last, *other]


def _joined_links(one: list[Facts], other: list[Facts]) -> list[Facts]:
    """Return every sender with what it sent in both parts."""
    found = {(link["system"], link["component"]): dict(link) for link in one}
    for link in other:
        key = (link["system"], link["component"])
        if key not in found:
            found[key] = dict(link)
            continue
        before = found[key]
        spans_s = [each["messages"] / each["rate_hz"] for each in (before, link) if each["rate_hz"]]
        for name in ("messages", "lost", "reordered"):
            before[name] += link[name]
        span_s = sum(spans_s)
        before["rate_hz"] = round(before["messages"] / span_s, 2) if span_s else None
        sent = before["lost"] + before["messages"]
        before["loss_percent"] = round(100 * before["lost"] / sent, 3) if sent else 0.0
    return [found[key] for key in sorted(found)]


def _joined_checks(one: list[Facts], other: list[Facts], shift_s: float) -> list[Facts]:
    """Return the worse finding of each check, worst first; reasons say which part they are of."""
    found = {check["name"]: check for check in one}
    for check in other:
        before = found.get(check["name"])
        if before is None or LEVELS.index(check["level"]) < LEVELS.index(before["level"]):
            since = f"in the part from {shift_s:.0f} s on: "
            found[check["name"]] = {**check, "reason": since + check["reason"]}
    return sorted(found.values(), key=lambda check: LEVELS.index(check["level"]))


def _joined_counts(one: dict[str, int], other: dict[str, int]) -> dict[str, int]:
    total = {name: one.get(name, 0) + other.get(name, 0) for name in {**one, **other}}
    return dict(sorted(total.items(), key=lambda pair: (-pair[1], pair[0])))


class Joint(NamedTuple):
    """How two parts stand to each other."""

    weights: tuple[float, float]  # of averages
    shift_s: float  # from the start of the log to that of the second part
    offset: int  # where in the file the second part starts


Join = Callable[[Any, Any, Joint], Any]

# of a plain value by the start or the end of its name; the first that fits counts
BY_NAME: tuple[tuple[Callable[[str], bool], Join], ...] = (
    (lambda name: name.startswith("start_"), lambda one, _other, _: one),
    (lambda name: name.startswith("end_"), lambda _one, other, _: other),
    (lambda name: name.startswith(("max", "longest_")), lambda one, other, _: max(one, other)),
    (lambda name: name.startswith("min_"), lambda one, other, _: min(one, other)),
    (
        lambda name: name.startswith(("mean_", "p50", "p95")) or name.endswith(("_hz", "_percent")),
        lambda one, other, joint: _average(one, other, joint.weights),
    ),
)


def _value(name: str, one: Any, other: Any, joint: Joint) -> Any:
    """Return one plain value of both parts, by its name."""
    if isinstance(other, str | bool):
        return other
    joins = (join for fits, join in BY_NAME if fits(name))
    join = next(joins, lambda a, b, _: round(a + b, 3))
    return join(one, other, joint)


def _measured(name: str, one: Facts, other: Facts, joint: Joint) -> Facts:
    """Return what was measured setpoint by setpoint."""
    join = _rms if name in SQUARED else _average
    return {
        key: max((v for v in (one[key], other[key]) if v is not None), default=None)
        if key == "max"
        else join(one[key], other[key], joint.weights)
        for key in one
    }


BY_KEY: dict[str, Join] = {
    **dict.fromkeys(FIRST, lambda one, _other, _: one),
    **dict.fromkeys(ALL, lambda one, other, _: one and other),
    **dict.fromkeys(SPANS, lambda one, other, _: _joined_spans(one, other, goes_on=False)),
    "modes": lambda one, other, _: _joined_spans(one, other, goes_on=True),
    "links": lambda one, other, _: _joined_links(one, other),
    "checks": lambda one, other, joint: _joined_checks(one, other, joint.shift_s),
    "counts": lambda one, other, _: _joined_counts(one, other),
    "frame_to_setpoint_ms": lambda one, other, joint: _measured("", one, other, joint),
    "setpoint_to_response_s": lambda one, other, joint: _measured("", one, other, joint),
    "tracking_rms": lambda one, other, joint: _measured("tracking_rms", one, other, joint),
}


def _both(name: str, one: Any, other: Any, joint: Joint) -> Any:
    """Return what both parts say under one name; what one of them does not say the other does."""
    if isinstance(other, list) and name not in BY_KEY.keys() - set(SPANS):
        other = _shifted(other, joint.shift_s, joint.offset)
    if one is None or other is None:
        return other if one is None else one
    if name in BY_KEY:
        return BY_KEY[name](one, other, joint)
    if isinstance(one, dict):
        return _joined(one, other, joint)
    return [*one, *other] if isinstance(one, list) else _value(name, one, other, joint)


def _joined(one: Facts, other: Facts, joint: Joint) -> Facts:
    """Return the facts of two parts."""
    weights = tuple(facts.get("setpoints", facts.get("flight_time_s", 0.0)) or 0.0
                    for facts in (one, other))  # fmt: skip
    here = joint._replace(weights=(weights[0], weights[1]))
    return {
        name: _both(name, one.get(name), other.get(name), here)
        for name in dict.fromkeys([*one, *other])
    }


def merge_parts(parts: Iterable[tuple[Facts, int]]) -> Facts:
    """Return the summary of a log from those of its parts, each with its place in the file.

    Counts, times, distances and extremes are those of the whole log; medians, percentiles and lags
    are averages of those of the parts, weighted by setpoints.
    """
    whole: Facts | None = None
    for facts, offset in parts:
        if whole is None:
            whole = facts
            continue
        shift_s = round(facts["start_unix_s"] - whole["start_unix_s"], 3)
        torn = whole["ends"].startswith("in the air") and facts["flights"] > 0
        both = _joined(whole, facts, Joint((0.0, 0.0), shift_s, offset))
        both["duration_s"] = round(max(whole["duration_s"], shift_s + facts["duration_s"]), 3)
        both["flights"] -= int(torn)
        if both["offboard"] and both["offboard"]["duration_s"]:
            rate_hz = both["offboard"]["setpoints"] / both["offboard"]["duration_s"]
            both["offboard"]["rate_hz"] = round(rate_hz, 2)
        whole = both
    if whole is None:
        raise ValueError("a log has at least one part")
    return whole
