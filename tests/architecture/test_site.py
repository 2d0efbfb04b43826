"""Each page of docs/ has one place in the site; `scripts/pages/site`, in the checks, builds it."""

import re

from tests.paths import DOCS

TOCTREE = re.compile(r"```\{toctree\}\n(.*?)```", re.DOTALL)


def test_each_page_has_one_place() -> None:
    trees = TOCTREE.findall((DOCS / "index.md").read_text())
    named = [line for tree in trees for line in tree.splitlines() if line and line[0] != ":"]
    pages = {path.stem for path in DOCS.glob("*.md")} - {"index"}
    assert sorted(named) == sorted(pages)


def test_tutorial_guides_reference_explanation_and_the_notebook_are_parts() -> None:
    parts = re.findall(r":caption: (.*)", (DOCS / "index.md").read_text())
    assert parts == [
        *("Tutorial", "How-to guides", "Reference", "Explanation", "Laboratory notebook"),
    ]
