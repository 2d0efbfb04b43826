"""What is installed is what its authors published, under licences that may be where they are."""

import re
import tomllib

import pytest

from scripts import licences
from scripts.licences import DOCUMENT, closure, complaints, kind_of, name_of
from tests.paths import ROOT

PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
PIN = re.compile(r"^([A-Za-z0-9._-]+)==([^\s]+)", re.MULTILINE)
HASH = re.compile(r"--hash=sha256:[0-9a-f]{64}")
AGAIN = "run scripts/hashes, which writes hashes.txt"


def plain(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def pins(name: str) -> dict[str, str]:
    return {plain(n): version for n, version in PIN.findall((ROOT / name).read_text())}


def test_all_that_flies_in_simulation_is_known_by_its_content() -> None:
    needed: set[str] = set()
    for requirement in (*PROJECT["dependencies"], *PROJECT["optional-dependencies"]["sim"]):
        closure(name_of(requirement), needed)
    assert {plain(name) for name in needed} <= set(pins("hashes.txt")), AGAIN


def test_what_is_known_by_its_content_is_what_is_pinned() -> None:
    constraints = pins("constraints.txt")
    assert {n: v for n, v in pins("hashes.txt").items() if constraints.get(n) != v} == {}, AGAIN
    for entry in (ROOT / "hashes.txt").read_text().split("\n\n"):
        blocks = re.split(r"\n(?=[a-zA-Z])", entry)
        assert all(HASH.search(block) for block in blocks if "==" in block)


def test_every_licence_may_be_where_it_is() -> None:
    assert list(complaints()) == []


def test_the_document_names_all_that_the_base_needs() -> None:
    text = DOCUMENT.read_text()
    base = [name for name, extras in licences.needed().items() if licences.BASE in extras]
    missing = [name for name in base if f"| {name} |" not in text]
    assert not missing, "run scripts/licences.py --write"


@pytest.mark.parametrize(
    ("licence", "kind"),
    [
        ("MIT License", "permissive"),
        ("Apache-2.0 OR BSD-2-Clause", "permissive"),
        ("Mozilla Public License 2.0 (MPL 2.0)", "weak"),
        ("GNU Lesser General Public License v3 (LGPLv3)", "lesser"),
        ("GPL-3.0-or-later", "strong"),
        ("GNU Affero General Public License v3", "strong"),
        ("Proprietary", "unknown"),
        ("", "unknown"),
    ],
)
def test_licences_are_told_apart(licence: str, kind: str) -> None:
    assert kind_of(licence) == kind


def test_a_package_under_the_gpl_is_no_part_of_what_flies(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(licences, "licence_of", lambda _: "GPL-3.0-only")
    monkeypatch.setattr(licences, "needed", lambda: {"numpy": {"base"}, "pytest": {"test"}})
    (complaint,) = complaints()
    assert complaint.startswith("numpy: under the GPL")
