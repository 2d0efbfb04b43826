"""Command: the seconds before a gate was missed, as the companion saw and decided them."""

import json
from argparse import Namespace
from collections.abc import Iterator

import numpy as np

from flightstack.logs.facts.values import Facts
from flightstack.logs.flight.decisions import PARTS, VELOCITIES
from flightstack.logs.flight.flight import Flight
from flightstack.logs.flight.why import FailedGate, Moment, find_failure
from flightstack.logs.given.arguments import check_folder
from flightstack.logs.given.opening import open_flight


def _facts(moment: Moment) -> Facts:
    return {
        "before_s": round(moment.before_s, 3),
        "stamp_us": moment.stamp_us,
        "command": np.round(moment.command, 4).tolist(),
        **{f"{part}_std": np.round(getattr(moment, f"{part}_std"), 4).tolist() for part in PARTS},
        "member": moment.member.tolist(),
        "modes": moment.modes.tolist(),
        "predictions": np.round(moment.predictions, 4).tolist(),
        "frame": str(moment.image) if moment.image else None,
    }


def _numbers(values: list[float]) -> str:
    return " ".join(f"{value:+6.2f}" for value in values)


def _lines(flight: Flight, failure: FailedGate) -> Iterator[str]:
    at_s = flight.seconds(failure.event.time_us)
    yield f"{failure.event.text}, at {at_s:.2f} s"
    if not failure.moments:
        yield "the log holds no decisions of the seconds before"
        return
    yield (
        f"{'before':>8}  {'command: ' + ', '.join(VELOCITIES):34}"
        + "  ".join(f"{part:>10}" for part in PARTS)
        + "  member     modes"
    )
    for moment in failure.moments:
        parts = "  ".join(f"{moment.std_m_s(part):10.3f}" for part in PARTS)
        member = " ".join(map(str, moment.member.tolist()))
        modes = " ".join(map(str, moment.modes.tolist()))
        command = _numbers(moment.command.tolist())
        yield f"{-moment.before_s:7.2f}s  {command:34}{parts}  {member:9}  {modes}"
        for number, prediction in enumerate(moment.predictions.tolist()):
            chosen = "*" if number in moment.member else " "
            yield f"{'':8}{chosen} {_numbers(prediction)}  member {number}"


def run(arguments: Namespace) -> int:
    """Print the moments, or draw them."""
    check_folder(arguments.frames)
    flight = open_flight(arguments.log, arguments.system)
    failure = find_failure(flight, arguments.frames, arguments.seconds)
    if failure is None:
        has_course = bool(flight.course_events or flight.gates or flight.gates_passed)
        none = "no gate was missed in this log" if has_course else "there is no course in this log"
        print(json.dumps({"failure": None}) if arguments.json else none)
        return 0
    if arguments.output is not None:
        from flightstack.logs.report.strip_picture import draw_strip  # noqa: PLC0415

        draw_strip(failure, arguments.output)
        print(f"wrote {arguments.output}")
    elif arguments.json:
        at_s = round(flight.seconds(failure.event.time_us), 3)
        moments = [_facts(moment) for moment in failure.moments]
        failed = {"kind": failure.event.kind, "text": failure.event.text, "at_s": at_s}
        print(json.dumps({"failure": failed, "moments": moments}))
    else:
        print("\n".join(_lines(flight, failure)))
    return 0
