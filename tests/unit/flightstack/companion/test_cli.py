"""The command line refuses what cannot be, in one line and with the right exit code."""

import socket
from pathlib import Path

import pytest

from flightstack.companion.cli import main


def refused(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str]:
    try:
        code = main(arguments)
    except SystemExit as end:
        code = int(end.code or 0)
    output = capsys.readouterr()
    assert output.out == ""
    assert output.err.count("\n") == 1
    assert output.err.startswith("flightstack.companion: ")
    return code, output.err


@pytest.mark.parametrize(
    "arguments",
    [
        ("--duration=0",),
        ("--duration=nan",),
        ("--duration=soon",),
        ("--takeoff-altitude=-3",),
        ("--speed-scale=inf",),
        ("--timeout=-1",),
        ("--seed=-1",),
        ("--seed=1.5",),
        ("--direction=up",),
        ("--nonsense",),
        ("--udp=14550", "--connect=tcp:host:1"),
        ("-v", "-q"),
        ("--part-memory=0",),
        ("--reach=-1",),
        ("--max-height=0",),
        ("--min-height=nan",),
        ("--min-height=60",),
        ("--max-height=2",),
    ],
)
def test_wrong_options_are_usage(
    arguments: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    code, text = refused(capsys, *arguments)
    assert code == 2
    assert arguments[-1].split("=")[0] in text


@pytest.mark.parametrize("option", ["--udp", "--connect"])
@pytest.mark.parametrize("string", ["nonsense", "99999", "ftp://host:21"])
def test_a_malformed_connection_string_is_usage(
    option: str, string: str, capsys: pytest.CaptureFixture[str]
) -> None:
    code, text = refused(capsys, f"{option}={string}")
    assert code == 2
    assert string in text


@pytest.mark.parametrize("option", ["model", "strategy", "perception", "policy", "pair-side"])
def test_a_pilot_takes_no_other_part_beside_it(
    option: str, capsys: pytest.CaptureFixture[str]
) -> None:
    code, text = refused(capsys, "--pilot=my:Pilot", f"--{option}=left")
    assert code == 2
    assert f"--{option}: not with --pilot" in text


def test_a_log_that_cannot_be_written_is_usage(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("not a folder")
    code, text = refused(capsys, f"--log={tmp_path}/file/a.tlog")
    assert code == 2
    assert f"{tmp_path}/file/a.tlog" in text


def test_a_busy_port_is_no_link(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = tmp_path / "a.tlog"
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as holder:
        holder.bind(("127.0.0.1", 0))
        port = holder.getsockname()[1]
        code, text = refused(capsys, f"--udp={port}", f"--log={log}")
    assert code == 3
    assert str(port) in text
    assert not log.exists()


def test_an_unknown_model_is_told_before_a_vehicle_is_waited_for(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ("--connect=udpout:127.0.0.1:9", "--model=no/such", f"--log={tmp_path}/a.tlog")
    code, text = refused(capsys, *arguments)
    assert code == 4
    assert "no/such" in text


@pytest.mark.parametrize(
    ("content", "reason"),
    [(None, "No such file"), (b"secret", "holds neither"), (bytes(32), "all zeros")],
)
def test_a_bad_signing_key_is_usage(
    content: bytes | None, reason: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    key = tmp_path / "key"
    if content is not None:
        key.write_bytes(content)
    code, text = refused(capsys, f"--signing-key={key}", f"--log={tmp_path}/a.tlog")
    assert code == 2
    assert reason in text
    assert str(key) in text
    assert not (tmp_path / "a.tlog").exists()


def test_images_that_cannot_be_recorded_are_usage(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "a.frames").write_text("not a folder")
    code, text = refused(capsys, "--record-frames", f"--log={tmp_path}/a.tlog")
    assert code == 2
    assert "a.frames: File exists" in text
