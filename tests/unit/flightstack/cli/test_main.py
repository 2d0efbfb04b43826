"""One command: it finds its sub-commands, and refuses in one line what is none."""

import importlib
import subprocess
import sys

import pytest

from flightstack import __version__
from flightstack.cli.commands import COMMANDS
from flightstack.cli.completion import SHELLS
from flightstack.cli.main import main
from tests.paths import ROOT


def ended(*words: str) -> int:
    try:
        return main(words)
    except SystemExit as end:
        return int(end.code or 0)


def test_it_says_its_version(capsys: pytest.CaptureFixture[str]) -> None:
    assert ended("--version") == 0
    assert capsys.readouterr().out == f"flightstack {__version__}\n"


def test_without_a_command_it_lists_them(capsys: pytest.CaptureFixture[str]) -> None:
    assert ended() == 0
    listed = capsys.readouterr().out
    assert all(f"\n    {name}" in listed for name in COMMANDS)


@pytest.mark.parametrize("name", COMMANDS)
def test_each_command_calls_itself_by_its_name_here(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert ended(name, "--help") == 0
    output = capsys.readouterr().out
    assert output.startswith(f"usage: flightstack {name} ")
    assert "--print-config" in output


@pytest.mark.parametrize("name", COMMANDS)
def test_each_command_refuses_in_one_line_of_one_style(
    name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    first = next(
        iter(importlib.import_module(COMMANDS[name].module).__dict__.get("COMMANDS", {})), ""
    )
    words = [word for word in (first, "--nonsense") if word]
    assert ended(name, *words) == 2
    output = capsys.readouterr()
    assert output.out == ""
    assert output.err.count("\n") == 1
    assert output.err.startswith(f"flightstack {name}")
    assert output.err.endswith("; --help lists the options\n")


def test_an_unknown_command_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert ended("walk") == 2
    error = capsys.readouterr().err
    assert error.startswith("flightstack: ")
    assert "'walk'" in error
    assert error.count("\n") == 1


def test_an_error_keeps_its_exit_code(capsys: pytest.CaptureFixture[str]) -> None:
    assert ended("logs", "summary", "no/such.tlog") == 2
    assert capsys.readouterr().err.startswith("flightstack logs: ")


@pytest.mark.parametrize("shell", SHELLS)
def test_completion_knows_all_commands_and_their_options(
    shell: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert ended("completion", shell) == 0
    script = capsys.readouterr().out
    for name in (*COMMANDS, "--track-seed", "--print-config", "ladder", "report"):
        assert name in script


def test_a_reader_who_has_seen_enough_is_no_error() -> None:
    asked = f"{sys.executable} -m flightstack.cli completion bash | head -n 1"
    answer = subprocess.run(
        ["/bin/bash", "-c", asked], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert answer.stderr == ""


@pytest.mark.parametrize(
    ("words", "wanted"),
    [
        ("flightstack fly --tr", ["--track-seed"]),
        ("flightstack evaluate la", ["ladder"]),
        ("flightstack fly --config cons", ["constraints.txt"]),
        ("flightstack logs report cons", ["constraints.txt"]),
    ],
)
def test_bash_takes_the_completion(words: str, wanted: list[str]) -> None:
    asked = (
        f'eval "$({sys.executable} -m flightstack.cli completion bash)"; '
        f"COMP_WORDS=({words}); COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1)); _shtab_flightstack; "
        'echo "${COMPREPLY[@]}"'
    )
    answer = subprocess.run(
        ["/bin/bash", "-c", asked], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert answer.stdout.split() == wanted
