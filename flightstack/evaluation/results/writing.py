"""Write results.json and results.md of an experiment."""

import json
import math
from collections.abc import Iterable
from dataclasses import asdict
from pathlib import Path
from typing import Any

from flightstack.evaluation.results.markdown import cells, common_sections, figure, table
from flightstack.evaluation.results.summary import ExperimentSummary
from flightstack.evaluation.trials import paper

JSON_FILE, MARKDOWN_FILE = "results.json", "results.md"


def write(folder: Path, summary: ExperimentSummary, sections: Iterable[str]) -> None:
    """Write both files; the Markdown from sections, each a text with its heading."""
    write_json(folder / JSON_FILE, summary)
    (folder / MARKDOWN_FILE).write_text("\n".join(sections))


def write_json(path: Path, record: Any) -> None:
    """Write a record, not-a-numbers as null."""
    text = json.dumps(_plain(asdict(record)), indent=1, allow_nan=False)
    path.write_text(text + "\n")


def table_sections(summary: ExperimentSummary) -> list[str]:
    """Put the paper's Table II beside ours, then all else."""
    gates = summary.cells[0].gates_total
    recipes = ", ".join(sorted({cell.model.partition("/")[0] for cell in summary.cells}))
    return [
        f"# Table II, recipe {recipes}\n",
        f"## Gates passed, of {gates}\n\n" + _beside_paper(summary, gates),
        *common_sections(summary),
    ]


def plain_sections(summary: ExperimentSummary, title: str) -> list[str]:
    """Tell of any experiment."""
    gates = summary.cells[0].gates_total
    return [
        f"# {title}\n",
        f"## Gates passed, of {gates}\n\n" + cells(summary, lambda cell: figure(cell.gates)),
        *common_sections(summary),
    ]


def _beside_paper(summary: ExperimentSummary, gates: int) -> str:
    if gates != paper.GATES:
        ours = cells(summary, lambda cell: figure(cell.gates))
        return f"{ours}\nThe paper's means are of {paper.GATES} gates: nothing to compare.\n"
    header = ["row", *(text for name in summary.conditions for text in (name, "paper"))]
    lines = []
    for row in summary.rows:
        line = [row]
        for condition in summary.conditions:
            cell = summary.cell(row, condition)
            theirs = paper.MEAN_GATES.get(row, {}).get(condition)
            line += [
                "" if cell is None else figure(cell.gates),
                "" if theirs is None else f"{theirs:.2f}",
            ]
        lines.append(line)
    return table(header, lines) + "\nThe paper's figures are means of 12 trials on 6 tracks.\n"


def _plain(value: Any) -> Any:
    """Replace what JSON cannot say, not a number, by null."""
    if isinstance(value, dict):
        return {key: _plain(one) for key, one in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
