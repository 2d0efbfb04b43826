"""Command: every message as text, JSON or CSV, as mavlogdump prints them."""

import struct
import sys
from argparse import Namespace
from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from functools import partial
from itertools import chain
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from flightstack.logs.columns.log import Log
from flightstack.logs.columns.reading import read
from flightstack.logs.columns.segments import is_large, logs_of
from flightstack.logs.errors import LogFileError
from flightstack.logs.given.arguments import names_in, writing
from flightstack.logs.text.lines import LineOptions, csv_columns, lines
from flightstack.logs.tlog.packets import NO_TIME
from flightstack.mavlink_numbers import LINK_BITS

if TYPE_CHECKING:
    from pathlib import Path


def seconds_window(start_us: int, arguments: Namespace) -> tuple[int | None, int | None]:
    """Return --from and --to, of a log that starts then, as times since 1970; None: not given."""
    bounds = (arguments.start, arguments.end)
    first, last = (None if s is None else start_us + round(s * 1e6) for s in bounds)
    return first, last


def _reduced(log: Log, rate_hz: float) -> NDArray[np.bool_]:
    """Return which packets to keep so that no type comes more often than this."""
    keep = np.zeros(len(log), dtype=np.bool_)
    step_us = 1e6 / rate_hz
    for msgid in np.unique(log.packets.msgid).tolist():
        rows = np.flatnonzero(log.packets.msgid == msgid)
        last_us = -np.inf
        for row, time_us in zip(rows.tolist(), log.time_us[rows].tolist(), strict=True):
            if time_us - last_us >= step_us or time_us < last_us:
                keep[row] = True
                last_us = time_us
    return keep


def _holds(condition: str, log: Log, part: Log, system: int | None) -> NDArray[np.bool_]:
    """Return for which packets of a part of the log the condition holds, of the vehicle."""
    # expressions take a while to import
    from flightstack.logs.columns.expression import holds  # noqa: PLC0415
    from flightstack.logs.columns.senders import (  # noqa: PLC0415
        find_participants,
        main_autopilot,
    )

    vehicle = main_autopilot(find_participants(log), system)
    rows = np.searchsorted(log.packets.offset, part.packets.offset, side="right") - 1
    return holds(condition, log, rows, vehicle)


def chosen(arguments: Namespace) -> Iterator[Log]:
    """Yield what all filters let through: of a large log part by part, else at once."""
    types = names_in(arguments.types) or None
    looks_beyond = (arguments.condition, arguments.start, arguments.end)  # the types asked for
    is_part = all(given is None for given in looks_beyond)
    start_us: int | None = None
    if is_large(arguments.log):
        logs = logs_of(arguments.log)
    else:
        logs = iter([read(arguments.log, types=types if is_part else None)])
    for log in logs:
        if start_us is None:
            start_us = int(log.time_us[0]) if len(log) else 0
        yield _chosen(log, start_us, arguments)


def _chosen(log: Log, log_start_us: int, arguments: Namespace) -> Log:
    """Return what all filters let through of a log, or of a part of one that starts then."""
    types = names_in(arguments.types) or None
    start_us, end_us = seconds_window(log_start_us, arguments)
    system = arguments.system if arguments.source_system is None else arguments.source_system
    component = arguments.source_component
    part = log.select(
        types=types, system=system, component=component, start_us=start_us, end_us=end_us
    )
    if left_out := names_in(arguments.nottypes):
        part = part.rows(~np.isin(part.packets.msgid, part.matching_ids(left_out)))
    if arguments.link is not None:
        part = part.rows((part.packets.time_us & LINK_BITS) == arguments.link)
    if arguments.condition:
        part = part.rows(_holds(arguments.condition, log, part, system))
    if arguments.reduce_rate > 0:
        part = part.rows(_reduced(part, arguments.reduce_rate))
    return part


def write_tlog(logs: Iterable[Log], path: "Path") -> None:
    """Write the packets of the parts of a log to a new tlog, each with its time."""
    further = iter(logs)
    first = next(further)
    if not first.is_telemetry:
        raise LogFileError(
            f"{first.name} holds no MAVLink packets to write; use the command export"
        )
    with writing(path, remedy=""), path.open("wb") as file:
        for log in chain([first], further):
            times = np.where(log.packets.time_us == NO_TIME, log.time_us, log.packets.time_us)
            places = (log.packets.offset.tolist(), log.packets.end.tolist())
            for stamp, start, end in zip(times.view(np.uint64).tolist(), *places, strict=True):
                file.write(struct.pack(">Q", stamp) + log.source.read(start, end).tobytes())


def _options(parts: Callable[[], Iterable[Log]], arguments: Namespace) -> LineOptions:
    """Return how lines look; the parts are looked through for the columns of CSV alone."""
    kind = "json" if arguments.json else arguments.format
    columns = csv_columns(parts(), names_in(arguments.types)) if kind == "csv" else ()
    return LineOptions(
        format=kind,
        separator="\t" if arguments.csv_sep == "tab" else arguments.csv_sep,
        show_source=arguments.show_source,
        show_sequence=arguments.show_seq,
        csv_columns=columns,
        raw_cells=arguments.raw_cells,
    )


def run(arguments: Namespace) -> int:
    """Print the chosen messages, or write them to a tlog."""
    parts: Callable[[], Iterable[Log]] = partial(chosen, arguments)  # a large log is not kept
    if not is_large(arguments.log):
        kept = list(parts())
        parts = partial(iter, kept)
    if arguments.output is not None:
        write_tlog(parts(), arguments.output)
    elif arguments.show_types:
        print("\n".join(_types(parts())))
    elif not arguments.quiet:
        _print(parts, arguments)
    return 0


def _types(parts: Iterable[Log]) -> list[str]:
    """Return the names of the types in all parts, the most frequent first."""
    counts: Counter[str] = Counter()
    for part in parts:
        counts.update(part.counts)
    return sorted(counts, key=lambda name: (-counts[name], name))


def _print(parts: Callable[[], Iterable[Log]], arguments: Namespace) -> None:
    options = _options(parts, arguments)
    if options.csv_columns:
        print(options.separator.join(("timestamp", *options.csv_columns)), flush=True)
    for part in parts():
        for some in lines(part.mapped(), options):
            sys.stdout.buffer.write(some)
