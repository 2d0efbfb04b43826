"""Logs that others write: MAVProxy's own, and a vehicle's with MAVSDK at the other end."""

import contextlib
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import pytest
from mavsdk import ComponentType, Configuration, Mavsdk
from mavsdk.exceptions import MavsdkError
from mavsdk.plugins.action import Action

from flightstack.launch.instances import API_PORT, free_instance
from flightstack.logs import Log, read
from tests.flight.processes import ENVIRONMENT, process
from tests.unit.flightstack.logs.made_logs import pymavlink_messages, same

pytestmark = pytest.mark.flight
PATIENCE_S = 60.0
MAVSDK_SYSTEM = 245


def wait_until(condition: Callable[[], bool], what: str) -> None:
    deadline_s = time.monotonic() + PATIENCE_S
    while not condition():
        assert time.monotonic() < deadline_s, f"no {what} within {PATIENCE_S:g} s"
        time.sleep(0.1)


def assert_equals_pymavlink(path: Path, least: int) -> Log:
    """Compare every field of every message with what pymavlink decodes."""
    log = read(path)
    theirs = list(pymavlink_messages(path))
    assert len(theirs) >= least
    known = {name: n for name, n in log.counts.items() if not name.startswith("UNKNOWN_")}
    assert known == dict(Counter(m.get_type() for m in theirs))
    for name in known:
        table = log[name]
        expected = [m for m in theirs if m.get_type() == name]
        assert [round(m._timestamp * 1e6) for m in expected] == table.time_us.tolist()
        for field in table.names:
            pairs = zip(table[field], (getattr(m, field) for m in expected), strict=True)
            assert all(same(ours, value) for ours, value in pairs), (name, field)
    return log


@contextlib.contextmanager
def mavproxy(folder: Path, port: int) -> Iterator[None]:
    program = Path(sys.executable).with_name("mavproxy.py")
    command = [
        *(sys.executable, "-u", str(program), "--non-interactive", "--default-modules=link"),
        *(f"--master=udpin:127.0.0.1:{port}", f"--state-basedir={folder}"),
        f"--logfile={folder / 'mav.tlog'}",
    ]
    with (
        (folder / "mavproxy.txt").open("wb") as output,
        subprocess.Popen(
            command,
            cwd=folder,
            env=ENVIRONMENT,
            stdin=subprocess.PIPE,
            stdout=output,
            stderr=subprocess.STDOUT,
        ) as running,
    ):
        try:
            yield
        finally:
            running.terminate()
            with contextlib.suppress(subprocess.TimeoutExpired):
                running.wait(10.0)
            running.kill()


def test_logs_of_mavproxy_read_as_pymavlink_reads_them(tmp_path: Path) -> None:
    tlog, raw = tmp_path / "mav.tlog", tmp_path / "mav.tlog.raw"
    with free_instance() as instance:
        options = (f"--instance={instance}", "--speed-factor=3")
        with (
            process("sitl", *options, log=tmp_path / "vehicle.txt"),
            mavproxy(tmp_path, API_PORT + instance),
        ):
            wait_until(lambda: tlog.exists() and tlog.stat().st_size > 200_000, "log of MAVProxy")
    log = assert_equals_pymavlink(tlog, least=2000)
    assert not log.damage.regions or log.damage.is_cut
    stream = read(raw)
    assert not stream.damage.has_times
    first, second = (table["ATTITUDE"]["time_boot_ms"] for table in (log, stream))
    both, ours, theirs = np.intersect1d(first, second, assume_unique=True, return_indices=True)
    assert len(both) > 400  # MAVProxy begins and flushes the two at different times
    assert np.array_equal(log["ATTITUDE"]["yaw"][ours], stream["ATTITUDE"]["yaw"][theirs])
    assert np.all(np.diff(stream.time_us) >= 0)
    assert stream.time_us[-1] > 1_000_000


def test_logs_with_mavsdk_read_as_pymavlink_reads_them(tmp_path: Path) -> None:
    path = tmp_path / "vehicle.tlog"
    with free_instance() as instance:
        options = (f"--instance={instance}", "--speed-factor=3", f"--log={path}")
        with process("sitl", *options, log=tmp_path / "vehicle.txt"):
            kind = Configuration.create_with_component_type(ComponentType.GROUND_STATION)
            with Mavsdk(kind) as mavsdk:
                mavsdk.add_any_connection(f"udpin://127.0.0.1:{API_PORT + instance}")
                system = mavsdk.first_autopilot(timeout_s=PATIENCE_S)
                assert system is not None
                action = Action(system)
                wait_until(lambda: arms(action), "armed vehicle")
                wait_until(lambda: path.stat().st_size > 300_000, "log")
            kind.destroy()
    log = assert_equals_pymavlink(path, least=3000)
    assert MAVSDK_SYSTEM in log.packets.system
    assert "COMMAND_LONG" in log
    assert {loss.lost for loss in log.losses if loss.system == instance + 1} == {0}


def arms(action: Action) -> bool:
    try:
        action.arm()
    except MavsdkError:  # not yet armable
        return False
    return True
