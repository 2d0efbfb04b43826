"""Options from a TOML file: read back as they were printed, below the command line, or refused."""

import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from flightstack.arguments.config_file import as_toml, words_of
from flightstack.arguments.options import leaf, options_of, sub_parsers
from flightstack.arguments.parser import OptionParser
from flightstack.cli import commands
from flightstack.cli.commands import COMMANDS, SubCommand, parser_of
from flightstack.cli.main import main
from flightstack.errors import UsageError


def leaves() -> list[tuple[str, ...]]:
    found: list[tuple[str, ...]] = []
    for name in COMMANDS:
        below = sub_parsers(parser_of(name))
        found += [(name, word) for word in below if not sub_parsers(below[word])] or [(name,)]
    return found


def an_own_parser() -> OptionParser:
    parser = OptionParser(prog="own")
    parser.add_argument("place", nargs="+")
    either = parser.add_mutually_exclusive_group()
    either.add_argument("--speed", type=float, default=1.0)
    either.add_argument("--fast", action="store_true")
    parser.add_argument("-o", "--output", type=Path)
    parser.add_argument("-v", "--verbose", action="count", default=0)
    parser.add_argument("--rungs", nargs="+", default=["1"])
    parser.add_argument("--link", action="append", default=[])
    parser.add_argument("--needed", required=True, type=int, choices=range(1, 9))
    return parser


def words(tmp_path: Path, text: str, *given: str) -> list[str]:
    file = tmp_path / "own.toml"
    file.write_text(text)
    return words_of(file, an_own_parser(), given)


@pytest.mark.parametrize("command", leaves(), ids=" ".join)
def test_what_is_printed_is_read_as_the_same(command: tuple[str, ...], tmp_path: Path) -> None:
    def of_the_command() -> Any:
        return leaf(parser_of(command[0]), command[1:])[0]

    file = tmp_path / "all.toml"
    file.write_text(as_toml(of_the_command(), []))
    read = words_of(file, of_the_command(), [])
    assert as_toml(of_the_command(), read) == file.read_text()


def test_every_kind_of_option_is_read(tmp_path: Path) -> None:
    text = """
    speed = 2
    output = "a b.txt"
    verbose = 2
    rungs = ["1", "bad day"]
    link = ["one", "two"]
    needed = 3
    """
    parsed = an_own_parser().parse_args(["here", *words(tmp_path, text)])
    assert vars(parsed) == {
        "place": ["here"],
        "speed": 2.0,
        "fast": False,
        "output": Path("a b.txt"),
        "verbose": 2,
        "rungs": ["1", "bad day"],
        "link": ["one", "two"],
        "needed": 3,
    }


@pytest.mark.parametrize("given", ["--speed=3", "--fast", "--speed"])
def test_the_command_line_goes_before_the_file_and_so_does_a_rival(
    given: str, tmp_path: Path
) -> None:
    assert words(tmp_path, "speed = 2\nneeded = 1", given) == ["--needed=1"]


@pytest.mark.parametrize("given", ["-o", "-ofile", "--output", "--output=x"])
def test_every_spelling_of_an_option_counts(given: str, tmp_path: Path) -> None:
    assert words(tmp_path, 'output = "y"', given) == []


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("nonsense = 1", "unknown key 'nonsense'; known are speed, fast, output"),
        ("place = 'here'", "unknown key 'place'"),
        ("help = true", "unknown key 'help'"),
        ("fast = 1", "fast: expected true or false, got 1"),
        ("rungs = 'one'", "rungs: expected an array, got 'one'"),
        ("speed = true", "speed: expected a text or a number, got True"),
        ("link = [[1]]", r"link: expected a text or a number, got \[1\]"),
        ("speed = ", "not TOML"),
    ],
)
def test_what_cannot_be_read_is_one_line(text: str, complaint: str, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=complaint) as refusal:
        words(tmp_path, text)
    assert "\n" not in str(refusal.value)
    assert str(tmp_path / "own.toml") in str(refusal.value)


def test_what_is_printed_needs_nothing_and_says_what_each_option_is_for() -> None:
    printed = as_toml(parser_of("fly"), ["--track-seed", "7", "--model", "1.0"])
    assert "track-seed = 7  # which track (default 0)\n" in printed
    assert 'model = "1.0"  # which model flies' in printed
    assert "# strategy =  # how it decides" in printed
    assert set(options_of(parser_of("fly"))) >= {"laps", "json"}


def test_the_command_gets_what_the_file_says(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    seen: list[list[str]] = []

    def run(own: list[str], _: str) -> int:
        seen.append(own)
        return 5

    module = SimpleNamespace(build_parser=lambda _: an_own_parser(), main=run)
    monkeypatch.setitem(commands.COMMANDS, "own", SubCommand("", "own"))
    monkeypatch.setitem(sys.modules, "own", module)
    file = tmp_path / "own.toml"
    file.write_text("speed = 2\nrungs = ['1', '2']")
    assert main(["own", f"--config={file}", "here", "--fast", "--", "--speed"]) == 5
    assert seen == [["here", "--fast", "--rungs", "1", "2", "--", "--speed"]]
    assert main(["own", "--fast", "--print-config", "--config", str(file)]) == 0
    assert 'rungs = ["1", "2"]\n' in capsys.readouterr().out
    assert len(seen) == 1


def test_a_missing_file_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["fly", "--config", "no/such.toml"]) == 2
    assert capsys.readouterr().err == (
        "flightstack fly: --config no/such.toml: No such file or directory\n"
    )


def test_a_file_that_is_no_text_is_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "own.toml").write_bytes(b"\xff\xfe")
    assert main(["fly", "--config", str(tmp_path / "own.toml")]) == 2
    assert capsys.readouterr().err.endswith("own.toml: is no text in UTF-8\n")


def test_of_several_commands_one_must_be_named(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["evaluate", "--print-config"]) == 2
    assert "say which command first: ablation, benchmark" in capsys.readouterr().err
