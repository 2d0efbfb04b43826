from pathlib import Path

import pytest

from sitl.autopilot.parameters import Parameters
from sitl.errors import UsageError
from sitl.process.options.parameter_file import ParameterFile


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "vehicle.params"


def test_what_is_changed_is_there_again_in_the_next_run(path: Path) -> None:
    parameters = Parameters()
    kept = ParameterFile(path, parameters)
    parameters.set("COM_OF_LOSS_T", 2.3)
    parameters.set("NAV_DLL_ACT", 2)
    parameters.set("MAV_SYS_ID", 5)
    parameters.set("MAV_COMP_ID", 7)
    kept.save()
    later = Parameters()
    ParameterFile(path, later)
    assert later["COM_OF_LOSS_T"] == parameters["COM_OF_LOSS_T"]  # to the last bit
    assert later.get("NAV_DLL_ACT") == 2
    assert later.get("MAV_SYS_ID") == 1
    assert path.read_text().splitlines()[2:] == [
        "5\t1\tCOM_OF_LOSS_T\t2.299999952316284\t9",
        "5\t1\tNAV_DLL_ACT\t2\t6",
    ]


def test_a_link_stays_a_link_and_what_is_private_private(path: Path, tmp_path: Path) -> None:
    path.write_text("")
    path.chmod(0o600)
    link = tmp_path / "link.params"
    link.symlink_to(path)
    parameters = Parameters()
    kept = ParameterFile(link, parameters)
    parameters.set("NAV_DLL_ACT", 2)
    kept.save()
    assert link.is_symlink()
    assert path.stat().st_mode & 0o777 == 0o600
    assert "NAV_DLL_ACT" in path.read_text()


@pytest.mark.parametrize("folder", ["vehicle.params", "nowhere"])
def test_a_file_that_could_not_be_kept_is_said_at_once(
    path: Path, tmp_path: Path, folder: str
) -> None:
    path.write_text("")
    with pytest.raises(UsageError, match=f"can't write to the folder .*{folder}"):
        ParameterFile(tmp_path / folder / "x.params", Parameters())


def test_a_default_of_old_is_forgotten(path: Path) -> None:
    parameters = Parameters()
    kept = ParameterFile(path, parameters)
    parameters.set("NAV_DLL_ACT", 2)
    kept.save()
    parameters.set("NAV_DLL_ACT", 0)
    kept.save()
    assert "NAV_DLL_ACT" not in path.read_text()


def test_nothing_is_written_while_nothing_changes(path: Path) -> None:
    ParameterFile(path, Parameters()).save()
    assert not path.exists()


def test_names_of_other_vehicles_are_passed_over(
    path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path.write_text("# a comment\n\n1\t1\tSOMETHING_ELSE\t1\t6\n1\t1\tNAV_DLL_ACT\t1\t6\n")
    parameters = Parameters()
    ParameterFile(path, parameters)
    assert parameters.get("NAV_DLL_ACT") == 1
    assert "1 parameters" in caplog.text


@pytest.mark.parametrize(
    ("line", "reason"),
    [
        ("NAV_DLL_ACT 2", "line 1: expected 5 fields"),
        ("1\t1\tNAV_DLL_ACT\t99\t6", "line 1: parameter NAV_DLL_ACT: must be 0 to 6"),
        ("1\t1\tNAV_DLL_ACT\tmany\t6", "must be a number"),
    ],
)
def test_what_cannot_be_is_named(path: Path, line: str, reason: str) -> None:
    path.write_text(line + "\n")
    with pytest.raises(UsageError, match=reason):
        ParameterFile(path, Parameters())


def test_a_file_that_cannot_be_written_is_told_of_and_the_flight_goes_on(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    parameters = Parameters()
    folder = tmp_path / "gone"
    folder.mkdir()
    kept = ParameterFile(folder / "vehicle.params", parameters)
    folder.rmdir()
    parameters.set("NAV_DLL_ACT", 2)
    kept.save()
    assert "not saved" in caplog.text


def test_a_folder_is_no_file(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="can't read"):
        ParameterFile(tmp_path, Parameters())
