from dataclasses import replace
from pathlib import Path

import pytest

from flightstack.errors import UsageError
from flightstack.launch.ports import Ports
from flightstack.launch.processes import Program, started
from flightstack.launch.px4 import Px4, prepared_px4
from flightstack.launch.request import FlightRequest

PORTS = Ports.of_px4_instance(3)
NOT_PX4 = "#!/bin/sh\necho starting; echo 'ERROR: PX4 server already running'; exit 255\n"


@pytest.fixture
def build(tmp_path: Path) -> Path:
    build = tmp_path / "build"
    (build / "bin").mkdir(parents=True)
    (build / "etc" / "init.d-posix").mkdir(parents=True)
    (build / "etc" / "init.d-posix" / "rcS").touch()
    binary = build / "bin" / "px4"
    binary.write_text(NOT_PX4)
    binary.chmod(0o755)
    return build


@pytest.mark.parametrize("named", [".", "bin/px4"])
def test_px4_is_told_its_instance_and_our_airframe(
    build: Path, named: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("PX4_PARAM_MPC_XY_CRUISE", "3.0")
    monkeypatch.setenv("PX4_SIM_SPEED_FACTOR", "4")
    with prepared_px4(FlightRequest(px4=build / named), PORTS) as px4:
        assert px4 is not None
        program = px4.program
        assert list(program.command) == [
            *(str((build / "bin" / "px4").resolve()), "-i", "3", "-d"),
            str((build / "etc").resolve()),
        ]
        assert program.environment is not None
        assert program.environment["PX4_SIM_MODEL"] == "none_iris"
        assert program.environment["PX4_PARAM_CA_ROTOR0_PX"] == "0.174"
        assert program.environment["PX4_PARAM_MPC_XY_CRUISE"] == "3.0"  # the user's own
        assert "PX4_SIM_SPEED_FACTOR" not in program.environment
        assert [path.name for path in px4.folder.iterdir()] == ["px4.out"]
    assert not px4.folder.exists()


def test_the_emulated_autopilot_needs_none() -> None:
    with prepared_px4(FlightRequest(), PORTS) as px4:
        assert px4 is None


def test_what_is_no_px4_is_said_in_one_line(build: Path, tmp_path: Path) -> None:
    request = FlightRequest(px4=tmp_path)
    with pytest.raises(UsageError, match=r"no PX4; name .*bin/px4"), prepared_px4(request, PORTS):
        pass
    (build / "etc" / "init.d-posix" / "rcS").unlink()
    request = replace(request, px4=build)
    with pytest.raises(UsageError, match=r"no etc/init\.d-posix/rcS"), prepared_px4(request, PORTS):
        pass


def test_a_folder_that_holds_something_is_refused(build: Path) -> None:
    request = FlightRequest(px4=build, px4_folder=build)
    with pytest.raises(UsageError, match="is not empty"), prepared_px4(request, PORTS):
        pass


def test_a_px4_that_ends_by_itself_is_told_with_its_words(build: Path) -> None:
    idle = Program(command=["sleep", "600"])
    with prepared_px4(FlightRequest(px4=build), PORTS) as px4:
        assert isinstance(px4, Px4)
        with started(idle, idle, px4.program) as pair:
            assert pair.px4 is not None
            pair.px4.wait(10.0)
            died = px4.explain_end(pair)
    assert died == "PX4 ended with 255: ERROR: PX4 server already running"
    assert pair.vehicle.returncode is not None
    assert pair.companion.returncode is not None
