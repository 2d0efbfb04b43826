"""What is kept of the dialect is what the dialect says, or it is not used."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from flightstack.logs import definitions as of_dialect
from tests.unit.flightstack.logs.made_logs import flight_messages, tlog


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "flightstack" / "definitions.json"


def read_anew() -> dict[int, of_dialect.Definition]:
    return of_dialect.definitions.__wrapped__()


def test_what_is_kept_equals_the_dialect(cache: Path) -> None:
    fresh = of_dialect.from_pymavlink()
    assert read_anew() == fresh
    assert cache.exists()
    assert read_anew() == fresh


@pytest.mark.usefixtures("cache")
def test_the_second_time_the_dialect_is_not_imported(tmp_path: Path) -> None:
    read_anew()
    log = tmp_path / "log.tlog"
    log.write_bytes(tlog(flight_messages(50)))
    code = (
        "import sys; from flightstack.logs.cli import main; main(sys.argv[1:]);"
        "slow = ('pymavlink', 'numpy.ma', 'numpy.random', 'scipy', 'matplotlib');"
        "print([name for name in slow if name in sys.modules], file=sys.stderr)"
    )
    command = [sys.executable, "-c", code, "dump", str(log), "--types", "ATTITUDE"]
    ran = subprocess.run(command, capture_output=True, text=True, check=True)
    assert ran.stdout.count("ATTITUDE") == 20
    assert ran.stderr.strip() == "[]"


def test_another_dialect_is_read_anew(cache: Path) -> None:
    fresh = read_anew()
    kept = json.loads(cache.read_text())
    kept["stamp"][-1] += 1
    kept["messages"]["30"][0] = "ALTITUDE_OF_ANOTHER_TIME"
    cache.write_text(json.dumps(kept))
    assert read_anew() == fresh
    assert json.loads(cache.read_text())["messages"]["30"][0] == "ATTITUDE"


@pytest.mark.parametrize("text", ["", "[]", "{}", "null", '{"stamp": 1', '{"messages": {}}'])
def test_a_damaged_cache_is_written_anew(cache: Path, text: str) -> None:
    cache.parent.mkdir()
    cache.write_text(text)
    assert read_anew()[30].name == "ATTITUDE"
    assert json.loads(cache.read_text())["messages"]["30"][0] == "ATTITUDE"


def test_without_a_place_for_the_cache_it_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert read_anew()[30].name == "ATTITUDE"
