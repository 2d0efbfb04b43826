"""What the house asks of every file: small, and free of any one machine."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

from tests.paths import ROOT

LINES_PER_FILE = 300
LINES_PER_FUNCTION = 40
# Assembled here, so that this file does not find itself.
FOREIGN = re.compile(
    "|".join(
        [
            *(rf"(?<![\w.]){re.escape('/' + home)}/" for home in ("work", "root", "home", "Users")),
            re.escape("pypi" + ".org"),
            re.escape("python" + "hosted"),
            re.escape("registry.npm" + "js"),
            re.escape("deb.debian" + ".org"),
            re.escape("download.pytorch" + ".org"),
        ]
    )
)


def tracked(pattern: str) -> list[Path]:
    listing = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "--", pattern]
    names = subprocess.run(listing, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    return [ROOT / name for name in names.splitlines() if (ROOT / name).is_file()]


def docstring_lines(node: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    return len((ast.get_docstring(node, clean=False) or "").splitlines())


def too_long(path: Path) -> list[str]:
    text = path.read_text()
    name = path.relative_to(ROOT)
    lines = len(text.splitlines())
    found = [f"{name}: {lines} lines"] if lines > LINES_PER_FILE else []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and node.end_lineno:
            length = node.end_lineno - node.lineno + 1 - docstring_lines(node)
            if length > LINES_PER_FUNCTION:
                found.append(f"{name}:{node.lineno} {node.name}: {length} lines")
    return found


def test_files_and_functions_stay_small() -> None:
    offenders = [offence for path in tracked("*.py") for offence in too_long(path)]
    assert not offenders, "\n".join(offenders)


def test_no_file_names_a_machine_or_a_registry() -> None:
    offenders = []
    for path in tracked("."):
        try:
            text = path.read_text()
        except UnicodeDecodeError:
            continue  # weights, pictures, logs
        offenders += [
            f"{path.relative_to(ROOT)}:{number} {line.strip()[:80]}"
            for number, line in enumerate(text.splitlines(), 1)
            if FOREIGN.search(line)
        ]
    assert not offenders, "\n".join(offenders)


def test_every_python_file_says_what_it_is_for() -> None:
    paths = [*tracked("flightstack/*.py"), *tracked("sitl/*.py"), *tracked("scripts/*.py")]
    silent = [path for path in paths if not ast.get_docstring(ast.parse(path.read_text()))]
    assert not silent, silent


@pytest.mark.parametrize("document", ["README.md", "CONTRIBUTING.md", "docs/command-line.md"])
def test_documented_scripts_exist(document: str) -> None:
    text = (ROOT / document).read_text()
    scripts = set(re.findall(r"(?:\./)?(scripts/[\w/.-]*\w)", text))
    assert scripts
    missing = [name for name in scripts if not (ROOT / name).exists()]
    assert not missing, missing


def test_no_page_installs_what_no_index_has() -> None:
    """The package is in a checkout or at an address, and not to be had by its name alone."""
    by_name = re.compile(r"pip install[^\n]*'?flightstack(\[[^\]]*\])?'?(?! @)[`\s]")
    pages = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *(ROOT / "docs").glob("*.md")]
    said = [
        f"{page.name}: {found[0]}" for page in pages for found in by_name.finditer(page.read_text())
    ]
    assert not said, said


@pytest.mark.parametrize("document", ["README.md", "CONTRIBUTING.md", "docs/command-line.md"])
def test_documented_modules_run(document: str) -> None:
    modules = set(
        re.findall(r"python3?(?:\.11)? -m ([a-z_]+(?:\.[a-z_]+)*)", (ROOT / document).read_text())
    )
    own = {module for module in modules if module.split(".")[0] in ("sitl", "flightstack")}
    missing = [name for name in own if not (ROOT / Path(*name.split(".")) / "__main__.py").exists()]
    assert not missing, missing


def test_the_options_of_fly_are_documented() -> None:
    section = (ROOT / "docs" / "command-line.md").read_text().partition("## `./scripts/fly`")[2]
    listed = set(re.findall(r"^\| `(--[a-z0-9-]+)", section.partition("##")[0], re.MULTILINE))
    command = [sys.executable, str(ROOT / "scripts" / "fly_course.py"), "--help"]
    helped = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    assert listed == set(re.findall(r"^  (--[a-z0-9-]+)", helped, re.MULTILINE))
