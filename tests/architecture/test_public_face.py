"""Outside of the vehicle only its public face is imported, and that loads no more than it needs."""

import ast
import subprocess
import sys
from pathlib import Path

import sitl
from tests.paths import ROOT

INSIDERS = {
    ROOT / "scripts" / "bench" / "profiled.py",  # times the parts by name
    ROOT / "scripts" / "fuzz" / "vehicle_targets.py",  # feeds the parsers
}
REPORT_LOADED = """
import sys
exec(sys.argv[1])
print(*(name for name in ("numpy", "pybullet", "cv2", "pymavlink") if name in sys.modules))
"""


def loaded_by(statement: str) -> list[str]:
    command = [sys.executable, "-c", REPORT_LOADED, statement]
    return subprocess.run(
        command, cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout.split()


def inner_imports(path: Path) -> list[str]:
    found = []
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom):
            found += [node.module or ""]
        elif isinstance(node, ast.Import):
            found += [alias.name for alias in node.names]
    return [name for name in found if name.startswith("sitl.")]


def test_only_the_public_face_is_imported_from_outside() -> None:
    paths = {*(ROOT / "flightstack").rglob("*.py"), *(ROOT / "scripts").rglob("*.py")}
    offenders = {str(path): inner_imports(path) for path in paths - INSIDERS}
    assert not {path: names for path, names in offenders.items() if names}


def test_every_public_name_is_there() -> None:
    assert sorted(sitl.__all__) == sorted(set(sitl.__all__))
    assert all(getattr(sitl, name) is not None for name in sitl.__all__)


def test_it_loads_what_a_name_needs_and_greets_nobody() -> None:
    assert loaded_by("import sitl") == []
    assert loaded_by("from sitl import Gate, SitlError, parse_conditions, yaw_of") == []
    assert loaded_by("from sitl import Simulation") == ["numpy", "pybullet", "cv2"]
