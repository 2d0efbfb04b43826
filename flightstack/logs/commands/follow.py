"""Command: events and rates of a log that is being written, or of a live link."""

import json
import time
from argparse import Namespace
from pathlib import Path

from flightstack.logs.columns.live import GrowingFile, PieceReader, at_times, open_link
from flightstack.logs.columns.log import Log
from flightstack.logs.facts.events import LiveEvents
from flightstack.logs.facts.values import Facts
from flightstack.logs.given.arguments import names_in
from flightstack.logs.text.lines import LineOptions, lines
from flightstack.printable import printable

PAUSE_S = 0.05
RATES_EVERY_S = 1.0


def _said(event: Facts) -> str:
    if event["event"] == "rates":
        parts = [
            f"{source} {rate['rate_hz']:.0f} Hz"
            + (f" (lost {rate['loss_percent']:.1f} %)" if rate["loss_percent"] else "")
            for source, rate in event["sources"].items()
        ]
        return f"{event['rate_hz']:8.1f} messages/s  " + ", ".join(parts)
    stamp = time.strftime("%H:%M:%S", time.localtime(event["time_us"] * 1e-6))
    level = f"{event['level']}: " if "level" in event else ""
    return f"{stamp}  {event['source']:>7}  {event['event']:8}  {level}{printable(event['text'])}"


def _show(event: Facts, *, as_json: bool) -> None:
    print(json.dumps(event) if as_json else _said(event), flush=True)


def _messages(log: Log, types: list[str], *, as_json: bool) -> None:
    part = log.select(types=types)
    options = LineOptions(format="json" if as_json else "standard", show_source=True)
    for text in lines(part, options):
        print(text.decode(), end="", flush=True)


def run(arguments: Namespace) -> int:
    """Print what comes until interrupted, or for --seconds."""
    is_file = Path(arguments.source).exists()
    receive = (
        GrowingFile(Path(arguments.source), from_start=arguments.from_start)
        if is_file
        else open_link(arguments.source)
    )
    types = names_in(arguments.types)
    reader, events = PieceReader(), LiveEvents()
    started = rated = time.monotonic()
    while not arguments.seconds or time.monotonic() - started < arguments.seconds:
        data = receive()
        log = reader.feed(data) if data else None
        if log is not None and len(log):
            log = log if is_file else at_times(log, time.time_ns() // 1000)
            for event in events.of(log):
                _show(event, as_json=arguments.json)
            if types:
                _messages(log, types, as_json=arguments.json)
        if not data:
            time.sleep(PAUSE_S)
        now = time.monotonic()
        if now - rated >= RATES_EVERY_S:
            _show(events.rates(now - rated), as_json=arguments.json)
            rated = now
    return 0
