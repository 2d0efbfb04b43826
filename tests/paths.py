"""Where the tests find what stands beside the code."""

from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
GOLDEN = ROOT / "tests" / "data" / "missed_gate.tlog"
