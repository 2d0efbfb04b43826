"""A vehicle's folder is gone when it ends, and a killed one's at the next start."""

import signal
import subprocess
import sys
import time
from pathlib import Path

from sitl.process.vehicle_folder import PREFIX, YOUNG_S, sweep, vehicle_folder

OLD_S = 2 * YOUNG_S
KILLED = """
import sys, time
from pathlib import Path
from sitl.process.vehicle_folder import vehicle_folder
with vehicle_folder(Path(sys.argv[1])) as folder:
    (folder / "flight.log").write_text("x")
    print(folder, flush=True)
    time.sleep(60)
"""


def test_a_folder_lasts_as_long_as_its_vehicle(tmp_path: Path) -> None:
    with vehicle_folder(tmp_path) as folder:
        assert folder.is_dir()
        assert folder.parent == tmp_path
        (folder / "kept").write_text("x")
    assert list(tmp_path.iterdir()) == []


def test_a_killed_vehicles_folder_goes_and_a_living_ones_stays(tmp_path: Path) -> None:
    command = [sys.executable, "-c", KILLED, str(tmp_path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as killed:
        assert killed.stdout is not None
        left = Path(killed.stdout.readline().strip())
        sweep(tmp_path, time.time() + OLD_S)
        assert (left / "flight.log").exists()  # it lives
        killed.send_signal(signal.SIGKILL)
        killed.wait(10.0)
    assert left.exists()
    sweep(tmp_path, time.time())
    assert left.exists()  # too young: it might be about to be locked
    sweep(tmp_path, time.time() + OLD_S)
    assert not left.exists()


def test_nothing_else_is_touched(tmp_path: Path) -> None:
    (tmp_path / "flightstack-other").mkdir()
    (tmp_path / f"{PREFIX}file").write_text("x")
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (tmp_path / f"{PREFIX}link").symlink_to(elsewhere)
    before = sorted(tmp_path.iterdir())
    sweep(tmp_path, time.time() + OLD_S)
    assert sorted(tmp_path.iterdir()) == before
