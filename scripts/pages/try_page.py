"""Do what a page says, as a reader would: every command, every file, in the order of the page.

    python scripts/pages/try_page.py docs/tutorial.md            # in full, from a fresh clone
    python scripts/pages/try_page.py --smaller docs/tutorial.md  # here, with small numbers

A page's steps are its blocks of commands (```sh, or a bare block of nothing else), its Python
(```python), and the files that it has its reader write: a block under `<!-- file: NAME -->`. They
run in one shell, in an empty folder that is removed. The suite runs the pages smaller.
"""

import argparse
import os
import re
import shlex
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BLOCK = re.compile(
    r"(?:<!-- file: (?P<file>\S+) -->\n)?^```(?P<kind>\w*)\n(?P<text>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)
COMMAND = re.compile(
    r"(?:\w+=\S+ )*(?:\./scripts/|flightstack |python |pip |git |cd |\. |cat |sed )"
)
CLONE = re.compile(r"https://ADDRESS/flightstack\.git")
HERE = f"{ROOT} flightstack"  # what is cloned, and where to
INSTALLING = re.compile(r"^(git clone|cd flightstack|\. \.venv|pip install)")
SUITE = re.compile(r"^\./scripts/test")  # which tries this page
PYTHON = '"$([ -x .venv/bin/python ] && echo .venv/bin/python || echo python)" -'
SMALLER = (  # what to put in the place of what, where a page is only tried
    (re.compile(r"^(\./scripts/fly|flightstack fly)(?!.*--fast)"), r"\1 --fast"),
    (re.compile(r"--tracks \d+"), "--tracks 1 --jobs 1"),
    (re.compile(r"--laps \d+"), "--laps 1"),
    (re.compile(r"(--rungs \S+)(?: (?!-)\S+)+"), r"\1"),
    (re.compile(r"--images \d+"), "--images 150"),
    (re.compile(r"--epochs \d+"), "--epochs 1"),
)
UNLEARNED = (re.compile(r'^(base = "\w+")$', re.MULTILINE), r"\1\ntraining.must_learn = false")
SHIMS = {  # where nothing is installed: this checkout by this Python
    "bin/python": f'exec {shlex.quote(sys.executable)} "$@"',
    "bin/flightstack": f'PYTHONPATH="$PYTHONPATH:{ROOT}" exec {shlex.quote(sys.executable)} '
    '-m flightstack.cli "$@"',
    "scripts/fly": 'exec flightstack fly "$@"',
}
FAILED = 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """One thing that a page has its reader do."""

    kind: str  # "command", "python" or "file"
    text: str
    file: str = ""


def steps_of(page: str) -> Iterator[Step]:
    """Read a page's steps, in order."""
    for block in BLOCK.finditer(page):
        text, kind = block["text"], block["kind"]
        if block["file"]:
            yield Step(kind="file", text=text, file=block["file"])
        elif kind == "python":
            yield Step(kind="python", text=text)
        elif kind == "sh" or (not kind and all(map(COMMAND.match, commands_of(text)))):
            yield from (Step(kind="command", text=line) for line in commands_of(text))


def commands_of(block: str) -> list[str]:
    """Join lines that go on, and drop comments."""
    lines = re.sub(r"\\\n\s*", "", block).splitlines()
    bare = (re.sub(r"(^|\s+)# .*$", "", line).strip() for line in lines)
    return [line for line in bare if line]


def made_smaller(command: str) -> str | None:
    """Give a command small numbers; None where it installs something, which is there already."""
    if INSTALLING.match(command):
        return None
    for pattern, replacement in SMALLER:
        command = pattern.sub(replacement, command)
    return command


def script_of(steps: list[Step], *, smaller: bool) -> str:
    """Write the shell script that does it all, and ends where something fails."""
    lines = ["set -eo pipefail"]
    if not (smaller or any(CLONE.search(step.text) for step in steps)):
        lines += [f"git clone --quiet {shlex.quote(str(ROOT))} flightstack", "cd flightstack"]
    for step in steps:
        if step.kind == "file":
            text = UNLEARNED[0].sub(UNLEARNED[1], step.text) if smaller else step.text
            lines += [f"echo '+ {step.file}'", _here(f"cat > {shlex.quote(step.file)}", text)]
            continue
        if step.kind == "python":
            lines += ["echo '+ python'", _here(PYTHON, step.text)]
            continue
        command = made_smaller(step.text) if smaller else CLONE.sub(HERE, step.text)
        if command is None or SUITE.match(command):
            lines.append(f"echo {shlex.quote(f'- {step.text}')}")
            continue
        lines += [f"echo {shlex.quote(f'+ {command}')}", command]
    return "\n".join(lines) + "\n"


def _here(command: str, text: str) -> str:
    return f"{command} <<'END_OF_BLOCK'\n{text}END_OF_BLOCK"


def try_page(page: Path, *, smaller: bool) -> int:
    """Run a page's steps in an empty folder; returns the shell's exit code."""
    steps = list(steps_of(page.read_text()))
    if not steps:
        print(f"{page}: no commands in it", file=sys.stderr)
        return FAILED
    with tempfile.TemporaryDirectory(prefix="page-") as folder:
        environment = dict(os.environ)
        if smaller:
            _lay_shims(Path(folder))
            environment["PATH"] = f"{folder}/bin{os.pathsep}{os.environ['PATH']}"
            environment["PYTHONPATH"] = str(ROOT)
        script = script_of(steps, smaller=smaller)
        code = subprocess.run(
            ["bash", "-c", script],  # noqa: S607
            cwd=folder,
            env=environment,
            check=False,
        ).returncode
    print(f"{page}: {'done' if code == 0 else f'failed with {code} after the last line with a +'}")
    return code


def _lay_shims(folder: Path) -> None:
    (folder / "docs").symlink_to(ROOT / "docs")
    for name, line in SHIMS.items():
        path = folder / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(f"#!/usr/bin/env bash\n{line}\n")
        path.chmod(0o755)


def main() -> int:
    """Try pages one after another; the exit code is that of the first that fails."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("page", nargs="+", type=Path)
    parser.add_argument(
        "--smaller", action="store_true", help="with small numbers, and this Python"
    )
    options = parser.parse_args()
    sys.stdout.reconfigure(line_buffering=True)  # type: ignore[union-attr]
    for page in options.page:
        if code := try_page(page.resolve(), smaller=options.smaller):
            return code
    return 0


if __name__ == "__main__":
    sys.exit(main())
