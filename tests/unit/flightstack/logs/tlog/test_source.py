"""Bytes of a log are the same however they are read."""

from pathlib import Path

from flightstack.logs.tlog.source import SMALL_BYTES, FileSource, MemorySource, mapped, open_source

DATA = bytes(range(256)) * 40


def test_a_mapped_log_holds_what_the_file_held_when_it_was_opened(tmp_path: Path) -> None:
    path = tmp_path / "log.tlog"
    path.write_bytes(DATA)
    source = open_source(path)
    with path.open("ab") as file:
        file.write(b"more")
    memory = mapped(source)
    assert isinstance(memory, MemorySource)
    assert (memory.name, memory.size) == (str(path), len(DATA))
    for start, stop in ((0, len(DATA)), (100, 300), (len(DATA) - 5, len(DATA) + 50)):
        assert memory.read(start, stop).tobytes() == source.read(start, stop).tobytes()


def test_what_cannot_be_mapped_stays_a_file(tmp_path: Path) -> None:
    path = tmp_path / "log.tlog"
    path.write_bytes(DATA)
    large = FileSource(str(path), SMALL_BYTES + 1)
    assert mapped(large) is large
    source = open_source(path)
    path.write_bytes(b"")
    assert mapped(source) is source
    path.unlink()
    assert mapped(source) is source
