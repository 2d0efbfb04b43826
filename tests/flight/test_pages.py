"""What pages have their readers do can be done: every command and file, with small numbers."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.paths import ROOT

pytestmark = pytest.mark.flight
TRY = (sys.executable, str(ROOT / "scripts" / "pages" / "try_page.py"), "--smaller")
PAGES = {  # and what of it a reader has by then
    "README.md": ["./scripts/test"],
    "docs/real-images.md": [],
    "docs/tutorial.md": [
        "git clone https://ADDRESS/flightstack.git",
        "cd flightstack",
        ". .venv/bin/activate",
        "pip install --constraint constraints.txt --editable '.[logs,evaluation]'",
    ],
}


def tried(page: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [*TRY, str(page)], capture_output=True, text=True, timeout=400, check=False
    )


@pytest.mark.parametrize("page", PAGES)
def test_what_a_page_says_can_be_done(page: str) -> None:
    done = tried(ROOT / page)
    assert done.returncode == 0, done.stdout[-3000:] + done.stderr[-3000:]
    steps = [line[2:] for line in done.stdout.splitlines() if line.startswith("- ")]
    assert [step for step in steps if not step.startswith("`")] == PAGES[page]


def test_a_page_whose_command_fails_is_found(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("```sh\nflightstack fly --laps none\n```\n\n```sh\ncat nothing\n```\n")
    done = tried(page)
    assert done.returncode != 0
    assert "+ cat nothing" not in done.stdout
    page.write_text("nothing to do")
    assert tried(page).returncode == 1


def test_files_commands_and_python_are_taken_in_order(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(
        "Save it:\n\n<!-- file: one.py -->\n```python\nVALUE = 7\n```\n\n"
        "```\na drawing\n```\n\n```python\nfrom one import VALUE\nopen('two', 'w').write("
        "str(VALUE))\n```\n\n```sh\ncat \\\n    two  # what came of it\n```\n"
    )
    done = tried(page)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[:4] == [
        "+ one.py",
        "+ python",
        "+ cat two",
        "7" + str(page) + ": done",
    ]
