"""Check the licences of all that is installed for this project, and list them.

    python scripts/licences.py [--write]

Every package that pyproject.toml leads to, directly or not, must name a licence that is known here.
What flies, trains or evaluates may stand under permissive licences, under the MPL, and in the one
case of pymavlink under the LGPL, which leaves programs that import it their own licence. A package
under the GPL may be a tool of the tests, and nothing that we import. --write brings the table in
docs/licences.md up to date with what is installed.
"""

import argparse
import re
import sys
import tomllib
from collections.abc import Iterator
from importlib.metadata import Distribution, PackageNotFoundError, distribution
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
DOCUMENT = ROOT / "docs" / "licences.md"
BEGIN, END = "<!-- written by scripts/licences.py -->\n", "<!-- to here -->\n"
BASE, TOOLS = (
    "base",
    ("test", "check", "fuzz", "docs"),
)  # extras whose packages nothing of ours imports
NAME = re.compile(r"[A-Za-z0-9._-]+")
TOOLS_OF_THEIR_OWN = ("MAVProxy",)  # that scripts/environment installs, for the tests
UNNAMED = {"atheris": "Apache-2.0"}  # whose metadata name none: as their LICENSE file says
PERMISSIVE = re.compile(
    r"MIT|0?BSD|Apache|Zlib|zlib|PSF|Python Software Foundation|CC0|BSL|ISC|HPND", re.IGNORECASE
)
WEAK = re.compile(r"MPL|Mozilla", re.IGNORECASE)
LESSER = re.compile(r"LGPL|Lesser", re.IGNORECASE)
STRONG = re.compile(r"GPL|General Public", re.IGNORECASE)
MAY_BE_LESSER = ("pymavlink",)


def licence_of(package: Distribution) -> str:
    """Return the licence that a package's own metadata name; empty if they name none."""
    about = package.metadata
    expression = about["License-Expression"]
    if expression:
        return str(expression)
    known = [c for c in about.get_all("Classifier", []) if c.startswith("License :: ")]
    if known:
        return "; ".join(each.rpartition(" :: ")[2] for each in known)
    return (about["License"] or UNNAMED.get(about["Name"], "")).partition("\n")[0]


def kind_of(licence: str) -> str:
    """Say how far a licence reaches: "permissive", "weak", "lesser", "strong" or "unknown"."""
    for kind, pattern in (("lesser", LESSER), ("strong", STRONG), ("weak", WEAK)):
        if pattern.search(licence):
            return kind
    return "permissive" if PERMISSIVE.search(licence) else "unknown"


def needed() -> dict[str, set[str]]:
    """Return what is installed of all that pyproject.toml leads to, and by which extras."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    found: dict[str, set[str]] = {}
    extras = {BASE: project["dependencies"], **project["optional-dependencies"]}
    for extra, requirements in extras.items():
        for requirement in requirements:
            if name_of(requirement) == project["name"]:  # its own extras stand here already
                continue
            for name in closure(name_of(requirement), set()):
                found.setdefault(name, set()).add(extra)
    for name in TOOLS_OF_THEIR_OWN:
        found.setdefault(name, set()).add("test")
    return found


def complaints() -> Iterator[str]:
    """Say which licences may not be where they are."""
    for name, extras in sorted(needed().items()):
        try:
            licence = licence_of(distribution(name))
        except PackageNotFoundError:
            continue
        kind = kind_of(licence)
        if kind == "unknown":
            yield f"{name}: the licence {licence!r} is not known to scripts/licences.py"
        elif kind == "lesser" and name not in MAY_BE_LESSER:
            yield f"{name}: under the LGPL ({licence}), as pymavlink alone may be"
        elif kind == "strong" and not extras <= set(TOOLS):
            yield f"{name}: under the GPL ({licence}), and more than a tool of the tests: {extras}"


def table() -> str:
    """Write what is needed, by whom and under which licence, as a table of Markdown."""
    rows = ["| package | licence | needed by |", "|---|---|---|"]
    for name, extras in sorted(needed().items(), key=lambda each: each[0].lower()):
        by = BASE if BASE in extras else ", ".join(sorted(extras))
        try:
            rows.append(f"| {name} | {licence_of(distribution(name))} | {by} |")
        except PackageNotFoundError:
            continue
    return "\n".join(rows) + "\n"


def closure(name: str, seen: set[str]) -> set[str]:
    """Return a package and all that it needs here, by their own names; what is not here is not."""
    try:
        package = distribution(name)
    except PackageNotFoundError:
        return seen
    own = str(package.metadata["Name"])
    if own in seen:
        return seen
    seen.add(own)
    for requirement in package.requires or ():
        if "extra ==" not in requirement:
            closure(name_of(requirement), seen)
    return seen


def name_of(requirement: str) -> str:
    """Return the name of the package that a requirement asks for."""
    found = NAME.match(requirement)
    return "" if found is None else found.group()


def main() -> int:
    """Check, and write if told to; 1 if a licence may not be where it is."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--write", action="store_true", help=f"bring {DOCUMENT.name} up to date")
    if parser.parse_args().write:
        head, _, rest = DOCUMENT.read_text().partition(BEGIN)
        _, _, tail = rest.partition(END)
        DOCUMENT.write_text(head + BEGIN + table() + END + tail)
    wrong = list(complaints())
    print("\n".join(wrong) or "every licence is known, and may be where it is")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
