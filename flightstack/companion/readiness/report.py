"""What a check has found, as one table, and as JSON."""

import json
from dataclasses import asdict, dataclass
from enum import StrEnum

COLUMNS = ("", "what", "found", "should be")


class ReadinessLevel(StrEnum):
    """How a thing is."""

    GOOD = "ok"
    ODD = "look"  # one can fly so, and should know it
    BAD = "no"  # so nobody flies


@dataclass(frozen=True, slots=True, kw_only=True)
class ReadinessItem:
    """One thing that was looked at."""

    what: str
    level: ReadinessLevel
    found: str
    wanted: str = ""


@dataclass(frozen=True, slots=True)
class Readiness:
    """All that was found, in the order in which it was looked at."""

    findings: tuple[ReadinessItem, ...]

    @property
    def is_ready(self) -> bool:
        """Whether nothing forbids a flight."""
        return all(each.level is not ReadinessLevel.BAD for each in self.findings)

    @property
    def verdict(self) -> str:
        """Return the last line: ready, or what is missing."""
        by = {
            kind: [each.what for each in self.findings if each.level is kind]
            for kind in ReadinessLevel
        }
        if not self.is_ready:
            return f"not ready: {', '.join(by[ReadinessLevel.BAD])}"
        odd = by[ReadinessLevel.ODD]
        return "ready" + (f"; look at {', '.join(odd)} (docs/real-vehicle.md)" if odd else "")

    def to_text(self) -> str:
        """Return the table and the verdict."""
        rows = [COLUMNS] + [
            (each.level.value, each.what, each.found, each.wanted) for each in self.findings
        ]
        widths = [max(len(row[column]) for row in rows) for column in range(len(COLUMNS) - 1)]
        lines = [
            "  ".join(
                [*(cell.ljust(width) for cell, width in zip(row, widths, strict=False)), row[-1]]
            ).rstrip()
            for row in rows
        ]
        return "\n".join([*lines, "", self.verdict])

    def to_json(self) -> str:
        """Return one line."""
        return json.dumps(
            {
                "ready": self.is_ready,
                "verdict": self.verdict,
                "findings": [asdict(each) for each in self.findings],
            }
        )
