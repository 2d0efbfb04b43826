"""Draw the companion's mission into docs/mission.md, from the tables that it walks.

`--check` writes nothing: it fails where the document shows something else.
"""

import sys
from collections.abc import Iterator
from pathlib import Path

from flightstack.companion.mission.records import MissionPhase, MissionRequest
from flightstack.companion.mission.table import (
    JUNCTIONS,
    TRANSITIONS,
    Junction,
    MissionEvent,
)

DOCUMENT = Path(__file__).parents[1] / "docs" / "mission.md"
BEGIN = "<!-- scripts/draw_mission.py writes from here -->\n"
END = "<!-- to here -->\n"

Node = MissionPhase | Junction
Arrow = tuple[Node, Node, MissionRequest | None]


def diagram() -> Iterator[str]:
    """Yield the lines of a Mermaid state diagram; events that share an arrow share its label."""
    yield from ("```mermaid", "stateDiagram-v2", "    [*] --> WAITING")
    yield from (f"    state {junction.name} <<choice>>" for junction in JUNCTIONS)
    labels: dict[Arrow, list[str]] = {}
    for phase, event, to, request, _ in _rows():
        labels.setdefault((phase, to, request), []).append(event.value)
    for junction, ways in JUNCTIONS.items():
        for stand, (to, request) in ways.items():
            labels.setdefault((junction, to, request), []).append(stand.value)
    for (start, to, request), words in labels.items():
        requested = f" / {request.value}" if request else ""
        yield f"    {start.name} --> {to.name}: {', '.join(words)}{requested}"
    yield from ("    DONE --> [*]", "```")


def table() -> Iterator[str]:
    """Yield the lines of a table of all transitions, with what each of them ends the flight by."""
    yield from ("| in | when | to | requests | ends by |", "|---|---|---|---|---|")
    for phase, event, to, request, outcome in _rows():
        ends = "its reason" if event is MissionEvent.HELD_TOO_LONG else outcome
        yield _line(phase.name, event.value, to.name, request and request.value, ends)
    for junction, ways in JUNCTIONS.items():
        for stand, (to, request) in ways.items():
            yield _line(junction.name, stand.value, to.name, request and request.value, None)


def drawn(document: str) -> str:
    """Return the document with what the tables say now."""
    before, _, rest = document.partition(BEGIN)
    after = rest.partition(END)[2]
    return before + BEGIN + "\n".join([*diagram(), "", *table(), ""]) + END + after


def _rows() -> Iterator[tuple[MissionPhase, MissionEvent, Node, MissionRequest | None, str | None]]:
    for phase, heeded in TRANSITIONS.items():
        for event, (to, request, outcome) in heeded.items():
            yield phase, event, to, request, outcome and outcome.value


def _line(*cells: str | None) -> str:
    return f"| {' | '.join(cell or '' for cell in cells)} |"


def main() -> int:
    """Write the document, or check it."""
    written = DOCUMENT.read_text()
    if sys.argv[1:] == ["--check"]:
        return int(drawn(written) != written)
    DOCUMENT.write_text(drawn(written))
    return 0


if __name__ == "__main__":
    sys.exit(main())
