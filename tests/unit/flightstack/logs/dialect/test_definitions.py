"""What is kept of the dialect is what the dialect says, or it is not used."""

import pwd
import subprocess
import sys
from pathlib import Path
from zlib import crc32

import pytest

from flightstack.logs.dialect import definitions as of_dialect
from tests.unit.flightstack.logs.made_logs import flight_messages, tlog


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "flightstack" / "definitions.txt"


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
    written = cache.read_text()
    head, _, lines = written.partition("\n")
    *stamp, changed_ns, checksum = head.split("\t")
    cache.write_text("\t".join([*stamp, str(int(changed_ns) + 1), checksum]) + "\n" + lines)
    assert read_anew() == fresh
    assert cache.read_text() == written


def test_what_is_kept_is_used(cache: Path) -> None:
    read_anew()
    head, _, lines = cache.read_text().partition("\n")
    lines = lines.replace("\tATTITUDE\t", "\tALTITUDE\t")
    stamp = head.split("\t")[:-1]
    cache.write_text("\t".join([*stamp, str(crc32(lines.encode()))]) + "\n" + lines)
    assert read_anew()[30].name == "ALTITUDE"


@pytest.mark.parametrize("head", ["", "3", "\t\t\t\t", "[]", "\udcff\udcfe"])
def test_a_damaged_cache_is_written_anew(cache: Path, head: str) -> None:
    fresh = read_anew()
    written = cache.read_bytes()
    cache.write_bytes(head.encode(errors="surrogateescape"))
    assert read_anew() == fresh
    assert cache.read_bytes() == written
    for damaged in (written[: len(written) // 2], written.replace(b"ATTITUDE", b"ALTITUDE")):
        cache.write_bytes(damaged)
        assert read_anew() == fresh
        assert cache.read_bytes() == written


def test_without_a_home_nothing_is_left_where_the_command_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.delenv("HOME", raising=False)
    monkeypatch.setattr(pwd, "getpwuid", {}.__getitem__)
    monkeypatch.chdir(tmp_path)
    assert read_anew()[30].name == "ATTITUDE"
    assert not list(tmp_path.iterdir())


def test_without_a_place_for_the_cache_it_goes_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "file"))
    assert read_anew()[30].name == "ATTITUDE"
