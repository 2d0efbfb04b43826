"""The tables of the report as HTML."""

from collections.abc import Iterable, Sequence
from html import escape
from itertools import islice

from flightstack.logs.checks import Finding, Level
from flightstack.logs.facts.values import Facts
from flightstack.logs.flight.flight import Flight
from flightstack.logs.flight.parameters import read_parameters

WORDS = {
    Level.ERROR: "error",
    Level.WARNING: "warning",
    Level.OK: "ok",
    Level.SKIPPED: "no data",
}
MAX_ROWS = 1500


def table(head: Sequence[str], rows: Iterable[Sequence[object]], numbers: set[int]) -> str:
    """Return a table; columns in `numbers` are set right."""

    def cell(tag: str, index: int, value: object) -> str:
        kind = ' class="number"' if index in numbers else ""
        return f"<{tag}{kind}>{escape(str(value))}</{tag}>"

    header = "".join(cell("th", index, name) for index, name in enumerate(head))
    body = "".join(
        "<tr>" + "".join(cell("td", index, value) for index, value in enumerate(row)) + "</tr>"
        for row in islice(rows, MAX_ROWS)
    )
    return f'<div class="scroll"><table><tr>{header}</tr>{body}</table></div>'


def checks_table(findings: Iterable[Finding]) -> str:
    """Return the health checks: verdict, reason, and what each means."""
    rows = "".join(
        f'<tr><td><span class="mark {finding.level.value}">{WORDS[finding.level]}</span></td>'
        f"<td><b>{escape(finding.title)}</b><br>{escape(finding.reason)}</td>"
        f'<td class="meaning">{escape(finding.meaning)}</td></tr>'
        for finding in findings
    )
    head = "<tr><th></th><th>check</th><th>what it means</th></tr>"
    return f'<table class="checks">{head}{rows}</table>'


def texts_table(flight: Flight) -> str:
    """Return all status texts."""
    rows = ((f"{flight.seconds(t.time_us):.2f}", t.source, t.level, t.text) for t in flight.texts)
    return table(("s", "source", "level", "text"), rows, {0})


def links_table(facts: Facts) -> str:
    """Return every sender with its rate and loss."""
    rows = (
        (
            f"{link['system']}/{link['component']}",
            link["messages"],
            "-" if link["rate_hz"] is None else f"{link['rate_hz']:.1f}",
            "-" if link["lost"] is None else link["lost"],
            "-" if link["loss_percent"] is None else f"{link['loss_percent']:.2f} %",
            ", ".join(part for part in (link["role"], link["counted"]) if part),
        )
        for link in facts["links"]
    )
    return table(("source", "messages", "Hz", "lost", "loss", "what it is"), rows, {1, 2, 3, 4})


def counts_table(messages: Iterable[Facts]) -> str:
    """Return every type by source with count and rate."""
    rows = (
        (
            each["type"],
            f"{each['system']}/{each['component']}",
            each["count"],
            "-" if each["rate_hz"] is None else f"{each['rate_hz']:.1f}",
        )
        for each in messages
    )
    return table(("message", "source", "count", "Hz"), rows, {2, 3})


def changes_table(flight: Flight) -> str:
    """Return the parameters that changed; "" where none did."""
    changes = read_parameters(flight).changes
    rows = [(f"{flight.seconds(c.time_us):.2f}", c.name, c.before, c.after) for c in changes]
    return table(("s", "parameter", "before", "after"), rows, {0, 2, 3}) if rows else ""


def damage_table(facts: Facts) -> str:
    """Return where the file lost bytes; "" where it did not."""
    rows = [
        (r["offset"], r["bytes"], r["kind"], f"{r['at_s']:.2f}") for r in facts["damage"]["regions"]
    ]
    return table(("offset", "bytes", "kind", "after s"), rows, {0, 1, 3}) if rows else ""
