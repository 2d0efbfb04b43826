"""What is promised is there; what cites us says which version it is."""

import os
import subprocess
import sys
from datetime import date

import yaml

import flightstack
from tests.paths import DOCS, ROOT

PROMISED = (DOCS / "public-names.txt").read_text().splitlines()


def test_no_public_name_is_gone() -> None:
    """One that has to go is deprecated first: docs/promise.md."""
    command = [sys.executable, str(ROOT / "scripts" / "pages" / "public_names.py")]
    here = os.environ | {"PYTHONPATH": str(ROOT)}
    found = subprocess.run(command, env=here, capture_output=True, text=True, check=True).stdout
    gone = set(PROMISED) - set(found.splitlines())
    assert not gone, sorted(gone)


def test_the_list_holds_names_of_each_kind() -> None:
    kinds = {"command", "csv", "entry-points", "exit-code", "option", "python", "toml"}
    assert {line.split()[0] for line in PROMISED} == kinds
    assert "option flightstack fly --track-seed" in PROMISED
    assert "python flightstack.fly(track_seed)" in PROMISED


def test_the_citation_is_of_this_version_and_of_those_who_hold_the_licence() -> None:
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert citation["cff-version"] == "1.2.0"
    assert citation["version"] == flightstack.__version__
    assert citation["authors"][0]["name"].lower() in (ROOT / "LICENSE").read_text().lower()
    assert citation["license"] == "BSD-3-Clause"
    assert all(1990 < each["year"] <= date.today().year for each in citation["references"])
    for each in citation["references"]:
        assert each["title"] in (ROOT / "README.md").read_text().replace("\n> ", " ")
