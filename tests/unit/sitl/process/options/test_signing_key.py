from pathlib import Path

import pytest

from sitl.errors import UsageError
from sitl.process.options.signing_key import read_key, write_key

KEY = bytes(range(1, 33))


@pytest.mark.parametrize("content", [KEY, KEY.hex().encode(), f"  {KEY.hex().upper()}\n".encode()])
def test_a_key_is_hexadecimal_or_raw(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "key"
    path.write_bytes(content)
    assert read_key(path) == KEY


@pytest.mark.parametrize(
    "content", [b"secret", KEY[:-1], bytes(32), b"00" * 32, b"\xff" * 64, KEY.hex().encode() * 2]
)
def test_what_is_no_key_is_refused(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "key"
    path.write_bytes(content)
    with pytest.raises(UsageError, match="64 hexadecimal digits"):
        read_key(path)


def test_a_missing_file_is_refused_and_an_empty_one_is_no_key_yet(tmp_path: Path) -> None:
    path = tmp_path / "key"
    with pytest.raises(UsageError, match="No such file"):
        read_key(path)
    path.touch()
    assert read_key(path) is None


def test_a_key_is_kept_for_its_owner_only(tmp_path: Path) -> None:
    path = tmp_path / "key"
    path.touch()
    path.chmod(0o644)
    write_key(path, KEY)
    assert read_key(path) == KEY
    assert path.stat().st_mode & 0o777 == 0o600
    write_key(path, None)
    assert read_key(path) is None
    assert list(tmp_path.iterdir()) == [path]


def test_a_key_that_cannot_be_kept_is_said_and_no_more(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    write_key(tmp_path / "no" / "key", KEY)
    assert "is not kept" in caplog.text
