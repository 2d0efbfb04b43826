from pathlib import Path

import pytest

from sitl.process.options.file_replacement import replace_file


def test_a_file_keeps_its_mode_unless_it_is_given_one(tmp_path: Path) -> None:
    path = tmp_path / "kept"
    path.write_text("old")
    path.chmod(0o640)
    replace_file(path, "new")
    assert (path.read_text(), path.stat().st_mode & 0o777) == ("new", 0o640)
    replace_file(path, "secret", mode=0o600)
    assert (path.read_text(), path.stat().st_mode & 0o777) == ("secret", 0o600)


def test_what_fails_leaves_what_was_there_and_nothing_else(tmp_path: Path) -> None:
    folder = tmp_path / "folder"
    folder.mkdir()
    with pytest.raises(OSError):  # noqa: PT011  of any kind
        replace_file(folder, "new")
    assert [path.name for path in tmp_path.iterdir()] == ["folder"]


def test_a_draft_left_by_a_killed_run_is_no_hindrance(tmp_path: Path) -> None:
    (tmp_path / "kept.new").write_text("half")
    replace_file(tmp_path / "kept", "whole")
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"kept": "whole"}
