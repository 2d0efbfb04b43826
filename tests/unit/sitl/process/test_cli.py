import pytest

import sitl.process.options.command_line
from sitl.process.cli import main


def test_a_signal_before_it_runs_ends_it_in_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(sitl.process.options.command_line, "parse", interrupt)
    assert main([]) == 130
    assert capsys.readouterr().err == "sitl: interrupted\n"
