"""Put the report together: words, figures and tables on one page that needs nothing else."""

import json
from functools import cache
from html import escape
from importlib.resources import files
from pathlib import Path
from string import Template

from flightstack import __version__
from flightstack.libraries import load_library
from flightstack.logs.checks import Finding, Level
from flightstack.logs.facts.messages import message_facts
from flightstack.logs.facts.summary import summarise
from flightstack.logs.facts.values import Facts
from flightstack.logs.flight.flight import Flight
from flightstack.logs.flight.why import FailedGate, find_failure
from flightstack.logs.report import tables
from flightstack.logs.report.beside_figure import (
    BesideLog,
    beside_facts,
    beside_figure,
    beside_words,
)
from flightstack.logs.report.course_figure import course_figure, has_course, has_path
from flightstack.logs.report.plotting import Json
from flightstack.logs.report.story import story, tiles
from flightstack.logs.report.strip import strip_html
from flightstack.logs.report.time_figure import time_figure
from flightstack.logs.text.summary_text import duration, started
from flightstack.printable import printable

PLOTLY_FILE = ("package_data", "plotly.min.js")


@cache
def plotly_script() -> str:
    """Return plotly.js, which the Python package brings along."""
    folder = files(load_library("plotly", "logs"))
    script = folder.joinpath(*PLOTLY_FILE).read_text(encoding="utf-8")
    return script.replace("</script", r"<\/script")


def _part(name: str) -> str:
    return files("flightstack.logs.report").joinpath(name).read_text(encoding="utf-8")


def verdict(findings: list[Finding]) -> tuple[Level, str]:
    """Return the worst level and its words for the top of the page."""
    for level, word in ((Level.ERROR, "error"), (Level.WARNING, "warning")):
        count = sum(finding.level is level for finding in findings)
        if count:
            return level, f"{count} {word}{'s' if count > 1 else ''}"
    return Level.OK, "healthy"


def _section(title: str, body: str, hint: str = "") -> str:
    note = f'<p class="hint">{escape(hint)}</p>' if hint else ""
    return f"<section><h2>{escape(title)}</h2>{note}{body}</section>" if body else ""


def _folded(title: str, body: str) -> str:
    return f"<section><details><summary>{title}</summary>{body}</details></section>" if body else ""


def _figure(name: str) -> str:
    return f'<div class="figure" id="figure-{name}"></div>'


def _sections(
    flight: Flight,
    facts: Facts,
    findings: list[Finding],
    failure: FailedGate | None,
    beside: Facts | None,
) -> str:
    messages = sorted(message_facts(flight.log), key=lambda each: -each["count"])
    hint = "Drag to zoom, double-click to see all again, hover for values."
    parts = [
        _section("Why did it miss?", strip_html(failure) if failure else ""),
        _section(
            "Course" if has_course(flight) else "Path",
            _figure("course"),
            "From above and from the side. " + hint,
        )
        if has_path(flight)
        else "",
        _section("Over time", _figure("time"), "All rows share one axis. " + hint),
        _section("Beside the vehicle's own log", _figure("beside"), beside_words(beside))
        if beside
        else "",
        _section("Health checks", tables.checks_table(findings)),
        _section("Status texts", tables.texts_table(flight) if flight.texts else ""),
        _section("Link", tables.links_table(facts)),
        _section("Parameters changed in flight", tables.changes_table(flight)),
        _section("File damage", tables.damage_table(facts), facts["damage"]["line_ends"]),
        _folded("Messages", tables.counts_table(messages)),
    ]
    return "\n".join(part for part in parts if part)


def _embedded(figures: dict[str, Json]) -> str:
    """Return the figures as JSON that no text in them can close the script element from."""
    return json.dumps(figures).replace("<", r"\u003c")


def make_page(
    flight: Flight,
    findings: list[Finding],
    images: Path | None = None,
    beside: BesideLog | None = None,
) -> str:
    """Return the report of a flight as HTML, beside the vehicle's own log of it if given."""
    facts = summarise(flight, findings)
    figures = {"course": course_figure(flight)} if has_path(flight) else {}
    figures["time"] = time_figure(flight)
    if beside is not None:
        figures["beside"] = beside_figure(flight, beside)
    level, words = verdict(findings)
    kind = facts["vehicle"]["kind"] if facts["vehicle"] else "no autopilot"
    when, length = started(facts["start_unix_s"]), duration(facts["duration_s"])
    about = f"{when}, {length}, {kind}, {facts['messages']} messages"
    failure = find_failure(flight, images)
    shown = "".join(
        f'<div class="tile"><b>{escape(value)}</b><span>{escape(name)}</span></div>'
        for value, name in tiles(facts)
    )
    return Template(_part("page.html")).substitute(
        version=__version__,
        title=escape(printable(Path(facts["log"]).name)),
        style=_part("style.css"),
        about=escape(about),
        level=level.value,
        verdict=escape(words),
        story=escape(story(facts)),
        tiles=shown,
        sections=_sections(
            flight, facts, findings, failure, beside_facts(flight, beside) if beside else None
        ),
        footer=f"Made by flightstack {__version__} from {escape(facts['log'])}.",
        figures=_embedded(figures),
        plotly=plotly_script(),
        script=_part("script.js"),
    )
