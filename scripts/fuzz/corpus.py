"""Keep a target's inputs in one file of text: an input a line, in base64, short ones first."""

import base64
from collections.abc import Iterable
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
CORPUS = ROOT / "tests" / "corpus"


def read(side: str, target: str) -> list[bytes]:
    """Read all inputs of a target of one side, "companion" or "vehicle"."""
    path = _path(side, target)
    lines = path.read_text().splitlines() if path.is_file() else []
    return [base64.b64decode(line) for line in lines]


def write(side: str, target: str, inputs: Iterable[bytes]) -> None:
    """Replace all inputs of a target."""
    lines = {base64.b64encode(each).decode() for each in inputs}
    text = "".join(f"{line}\n" for line in sorted(lines, key=lambda line: (len(line), line)))
    path = _path(side, target)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)


def _path(side: str, target: str) -> Path:
    return CORPUS / side / f"{target}.txt"
