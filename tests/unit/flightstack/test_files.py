from pathlib import Path

import pytest

from flightstack.files import replacing, write_whole


def test_replaces_a_file_by_text_with_its_line_ends_as_they_are(tmp_path: Path) -> None:
    path = tmp_path / "results.csv"

    for text in ("old", "a,ö\r\nb\n"):
        write_whole(path, text, durable=True)

    assert path.read_bytes() == "a,ö\r\nb\n".encode()
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("content", [b"\x00\xff", memoryview(b"\x00\xff")])
def test_writes_bytes_as_they_are(tmp_path: Path, content: bytes | memoryview) -> None:
    write_whole(tmp_path / "image.png", content)

    assert (tmp_path / "image.png").read_bytes() == b"\x00\xff"


def test_what_stood_there_is_read_until_the_block_ends(tmp_path: Path) -> None:
    path = tmp_path / "checkpoint.pt"
    path.write_text("old")

    with replacing(path) as draft:
        Path(draft).write_text("new")
        before = path.read_text()

    assert (before, path.read_text()) == ("old", "new")


def test_a_block_that_fails_leaves_the_old_file_and_no_draft(tmp_path: Path) -> None:
    path = tmp_path / "checkpoint.pt"
    path.write_text("old")

    with pytest.raises(TypeError), replacing(path) as draft, Path(draft).open("w") as file:
        file.writelines(["half of the n", None])  # type: ignore[list-item]

    assert list(tmp_path.iterdir()) == [path]
    assert path.read_text() == "old"


def test_a_place_that_cannot_be_taken_raises_and_leaves_no_draft(tmp_path: Path) -> None:
    taken = tmp_path / "taken"
    taken.mkdir()

    with pytest.raises(IsADirectoryError):
        write_whole(taken, "text")

    assert list(tmp_path.iterdir()) == [taken]
