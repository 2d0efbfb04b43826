"""A vehicle process with a signing key, and one that is given a file that is none."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.paths import ROOT
from tests.wire.vehicle_process import Vehicle, is_acknowledgement

pytestmark = pytest.mark.flight
KEY = bytes(range(1, 33))


def test_only_who_has_the_key_is_obeyed(tmp_path: Path) -> None:
    path = tmp_path / "key"
    path.write_text(KEY.hex())
    with Vehicle(f"--signing-key={path}") as vehicle:
        gcs, api = vehicle.gcs, vehicle.api
        for client in (gcs, api):
            client.codec.signing.secret_key = KEY
        vehicle.wait_until_up()
        gcs.command(520)
        gcs.codec.signing.sign_outgoing = True  # its stamp came with the vehicle's packets
        gcs.command(512, 148)
        answers = (520, 512)
        first = gcs.wait_for(
            lambda m: m.get_type() == "COMMAND_ACK" and m.command in answers, "answer"
        )
        assert first.command == 512
        assert first.get_signed()
        api.codec.signing.sign_outgoing = True
        api.command(512, 148)
        api.wait_for(is_acknowledgement(512))
        code, said = vehicle.end(15)
    assert code == 0
    assert "1 unsigned" in said


def test_a_file_without_a_key_is_refused_in_one_line(tmp_path: Path) -> None:
    path = tmp_path / "key"
    path.write_text("secret")
    command = [sys.executable, "-m", "sitl", f"--signing-key={path}"]
    run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert run.returncode == 2
    assert run.stderr.count("\n") == 1
    assert "64 hexadecimal digits" in run.stderr
