"""Table II in small: the same rows whatever happens on the way."""

import contextlib
import csv
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.flight.processes import ENVIRONMENT, run
from tests.paths import ROOT

pytestmark = pytest.mark.flight
ASKED = (
    *("table", "--recipe", "strong", "--rows", "m0-mi-mode", "m0-mean"),
    *("--levels", "1", "--tracks", "2", "--laps", "1"),
)
LIMIT_S = 300.0
NOT_COMPARED = ("retries", "commit")  # of other machines' moods; of whoever commits meanwhile


def command(out: Path, *options: str) -> list[str]:
    return [sys.executable, "-m", "flightstack.evaluation", *ASKED, f"--out={out}", *options]


def rows(out: Path) -> list[dict[str, str]]:
    with (out / "trials.csv").open(newline="") as file:
        found = list(csv.DictReader(file))
    return [{k: v for k, v in row.items() if k not in NOT_COMPARED} for row in found]


def traces(out: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in (out / "traces").iterdir()}


@contextlib.contextmanager
def running(
    out: Path, *options: str, scratch: Path | None = None
) -> Iterator[subprocess.Popen[str]]:
    """Start the command as the leader of a group, as a terminal does."""
    elsewhere = {} if scratch is None else {"TMPDIR": str(scratch)}
    with subprocess.Popen(
        command(out, *options),
        cwd=ROOT,
        env=ENVIRONMENT | elsewhere,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
    ) as process:
        try:
            yield process
        finally:
            process.kill()


def below(ancestor: int) -> dict[int, str]:
    """Name the processes that descend from one, by their ids."""
    parents, names = {}, {}
    for folder in Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            name, _, rest = (folder / "stat").read_text().partition("(")[2].rpartition(")")
            parents[int(folder.name)], names[int(folder.name)] = int(rest.split()[1]), name
    found = {ancestor}
    for _ in range(4):  # worker, fork server, flight
        found |= {pid for pid, parent in parents.items() if parent in found}
    return {pid: names[pid] for pid in found - {ancestor} if pid in names}


def wait_for(process: subprocess.Popen[str], name: str) -> int:
    """Wait until the command has a process of this name; returns its id."""
    deadline_s = time.monotonic() + LIMIT_S
    while time.monotonic() < deadline_s and process.poll() is None:
        found = [pid for pid, its_name in below(process.pid).items() if its_name == name]
        if found:
            return found[0]
        time.sleep(0.05)
    raise AssertionError(f"no process {name}")


def parent(pid: int) -> int:
    """Return who has started it."""
    return int(Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[1])


def assert_all_end(pids: dict[int, str]) -> None:
    """Expect that these end soon: fork servers see at once that nobody orders any more."""
    deadline_s = time.monotonic() + 10.0
    while left := [f"{pid} {name}" for pid, name in pids.items() if _lives(pid)]:
        assert time.monotonic() < deadline_s, left
        time.sleep(0.05)


def _lives(pid: int) -> bool:
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


@pytest.fixture(scope="module")
def alone(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Rows that were flown one after another."""
    out = tmp_path_factory.mktemp("table") / "alone"
    ended = run(command(out, "--jobs=1"), timeout_s=LIMIT_S)
    assert ended.code == 0, ended.stderr
    assert "Gates passed, of 8" in ended.stdout
    return out


def test_each_row_tells_a_flight(alone: Path) -> None:
    found = rows(alone)
    assert [(row["row"], row["track_seed"]) for row in found] == [
        (name, track) for name in ("m0-mi-mode", "m0-mean") for track in ("1000", "1001")
    ]
    for row in found:
        assert row["gates_total"] == "8"
        assert (row["outcome"] == "finished") == (row["gates_passed"] == "8")
        assert 1.0 < float(row["mean_speed_m_s"]) < 3.0
        assert 0.0 < float(row["aleatoric_vx"]) < 2.0
    assert len(traces(alone)) == len(found)
    assert "| m0-mean |" in (alone / "results.md").read_text()


def test_two_at_once_give_the_same_rows_though_a_process_is_killed(
    alone: Path, tmp_path: Path
) -> None:
    out = tmp_path / "killed"
    with running(out, "--jobs=2") as process:
        os.kill(wait_for(process, "companion"), signal.SIGKILL)
        _, said = process.communicate(timeout=LIMIT_S)
        assert process.returncode == 0, said
    assert rows(out) == rows(alone)
    assert traces(out) == traces(alone)
    assert said.count("flown again") == 1
    with (out / "trials.csv").open(newline="") as file:
        assert sorted(row["retries"] for row in csv.DictReader(file)) == ["0", "0", "0", "1"]


def test_an_interrupted_table_resumes(alone: Path, tmp_path: Path) -> None:
    out = tmp_path / "interrupted"
    with running(out, "--jobs=2", scratch=tmp_path) as process:
        deadline_s = time.monotonic() + LIMIT_S
        while not (out / "trials.csv").exists() or not rows(out):
            assert process.poll() is None
            assert time.monotonic() < deadline_s
            time.sleep(0.1)
        started = below(process.pid)
        os.killpg(process.pid, signal.SIGINT)
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(timeout=0.3)
        if process.poll() is None:  # it lets the flights that are in the air land
            os.killpg(process.pid, signal.SIGINT)  # of somebody impatient
        _, said = process.communicate(timeout=60.0)
        assert process.returncode == 130, said
    assert said.rstrip().endswith("interrupted")
    assert "Traceback" not in said
    first = rows(out)
    assert 1 <= len(first) < 4
    assert_all_end(started)
    assert [path.name for path in out.parent.iterdir()] == [out.name]  # nothing else is left
    ended = run(command(out, "--jobs=2"), timeout_s=LIMIT_S)
    assert ended.code == 0, ended.stderr
    assert f"{len(first)} trials stand already" in ended.stderr
    assert rows(out) == rows(alone)


def test_a_terminated_table_leaves_nothing_behind(tmp_path: Path) -> None:
    out = tmp_path / "terminated"
    with running(out, "--jobs=2", scratch=tmp_path) as process:
        wait_for(process, "companion")
        started = below(process.pid)
        process.terminate()
        _, said = process.communicate(timeout=60.0)
        assert process.returncode == 128 + signal.SIGTERM, said
    assert "Traceback" not in said
    assert_all_end(started)
    assert [path.name for path in tmp_path.iterdir()] == [out.name]


def test_a_killed_worker_is_told_on_disk(alone: Path, tmp_path: Path) -> None:
    out = tmp_path / "worker"
    with running(out, "--jobs=2") as process:
        server = parent(wait_for(process, "companion"))
        os.kill(parent(server), signal.SIGKILL)
        _, said = process.communicate(timeout=LIMIT_S)
        assert process.returncode == 0, said
    assert said.count("a worker process died: its trials are flown again") == 1
    assert rows(out) == rows(alone)
    assert traces(out) == traces(alone)
    with (out / "trials.csv").open(newline="") as file:
        assert sum(int(row["retries"]) for row in csv.DictReader(file)) == 2  # one a job
    with (out / "times.csv").open(newline="") as file:
        assert [row["deaths"] for row in csv.DictReader(file)].count("a worker process died") == 2
    assert "2 flights died and were flown again" in (out / "results.md").read_text()


def test_a_ray_cluster_gives_the_same_rows_though_a_worker_is_killed(
    alone: Path, tmp_path: Path
) -> None:
    pytest.importorskip("ray")
    out = tmp_path / "ray"
    with running(out, "--backend=ray", "--jobs=2") as process:
        wait_for(process, "companion")
        os.kill(wait_for(process, "ray::PoolActor.r"[:15]), signal.SIGKILL)
        _, said = process.communicate(timeout=LIMIT_S)
        assert process.returncode == 0, said
    assert said.count("a worker process died: its trials are flown again") == 1
    assert rows(out) == rows(alone)
    assert traces(out) == traces(alone)
