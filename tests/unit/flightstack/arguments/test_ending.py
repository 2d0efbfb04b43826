"""A command ends in one line where it could not do what it should, and with the code of that."""

import pytest

from flightstack.arguments.ending import run_command
from flightstack.errors import LinkError, UsageError


def test_what_a_command_returns_is_its_exit_code() -> None:
    assert run_command("fly", lambda: 3) == 3
    assert run_command("fly", lambda: None) == 0


@pytest.mark.parametrize(("error", "code"), [(UsageError("a\nb\x1b[2J"), 2), (LinkError("c"), 3)])
def test_an_error_of_ours_is_one_line_that_no_terminal_obeys(
    error: UsageError | LinkError, code: int, capsys: pytest.CaptureFixture[str]
) -> None:
    def fails() -> None:
        raise error

    assert run_command("flightstack fly", fails) == code
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("flightstack fly: ")
    assert line.isprintable()


def test_an_interruption_is_said(capsys: pytest.CaptureFixture[str]) -> None:
    def interrupted() -> None:
        raise KeyboardInterrupt

    assert run_command("train", interrupted, interrupted="go on") == 130
    assert capsys.readouterr().err == "train: go on\n"


def test_an_error_of_nobodys_making_is_not_hidden() -> None:
    def fails() -> None:
        raise ZeroDivisionError

    with pytest.raises(ZeroDivisionError):
        run_command("fly", fails)
