"""Every message type by source: how many, how often, from when to when."""

from collections.abc import Iterable, Iterator

import numpy as np

from flightstack.logs.columns.log import Log
from flightstack.logs.facts.values import Facts, rate_hz


def message_facts(log: Log) -> Iterator[Facts]:
    """Yield for every type and source how many, how often, from when to when."""
    start_us = int(log.time_us[0]) if len(log) else 0
    packets = log.packets
    key = packets.msgid.astype(np.int64) << 16 | packets.sender
    order = np.argsort(key, kind="stable")
    keys, first, counts = np.unique(key[order], return_index=True, return_counts=True)
    for value, start, count in zip(keys.tolist(), first.tolist(), counts.tolist(), strict=True):
        times = log.time_us[order[start : start + count]]
        span_s = float(times.max() - times.min()) * 1e-6
        yield {
            "type": log.name_of(value >> 16),
            "system": value >> 8 & 0xFF,
            "component": value & 0xFF,
            "count": count,
            "rate_hz": rate_hz(count, span_s),
            "first_s": round(float(times[0] - start_us) * 1e-6, 3),
            "last_s": round(float(times[-1] - start_us) * 1e-6, 3),
        }


def joined_message_facts(logs: Iterable[Log]) -> list[Facts]:
    """Return the same for a log that comes in parts, in the order of time."""
    found: dict[tuple[str, int, int], Facts] = {}
    start_us = None
    for log in logs:
        if not len(log):
            continue
        start_us = int(log.time_us[0]) if start_us is None else start_us
        shift_s = (int(log.time_us[0]) - start_us) * 1e-6
        for facts in message_facts(log):
            key = (facts["type"], facts["system"], facts["component"])
            first_s, last_s = (round(facts[name] + shift_s, 3) for name in ("first_s", "last_s"))
            before = found.setdefault(key, {**facts, "count": 0, "first_s": first_s})
            before["count"] += facts["count"]
            before["last_s"] = last_s
            span_s = last_s - before["first_s"]
            before["rate_hz"] = round((before["count"] - 1) / span_s, 2) if span_s > 0 else None
    return list(found.values())
