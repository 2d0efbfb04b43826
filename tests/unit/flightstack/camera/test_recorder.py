"""Images are kept bit by bit beside the log, and whoever flies never waits for the disk."""

import contextlib
import os
import threading
import time
from pathlib import Path

import cv2
import numpy as np
import pytest

from flightstack.camera import recorder as recorder_module
from flightstack.camera.recorder import ImageRecorder
from flightstack.errors import UsageError
from flightstack.records import Image
from tests.unit.flightstack.small_disk import small_disk

WAIT_S = 10.0


def image(stamp_us: int, size: int = 64) -> Image:
    rng = np.random.default_rng(stamp_us)
    rgb = rng.integers(0, 256, (size, size, 3), np.uint8)
    return Image(stamp_us=stamp_us, sequence=0, rgb=rgb)


def read_rgb(path: Path) -> np.ndarray:
    bgr = cv2.imread(str(path), cv2.IMREAD_COLOR)
    assert bgr is not None
    return cv2.cvtColor(bgr, cv2.COLOR_BGR2RGB)


def test_writes_each_image_as_it_was_under_its_stamp(tmp_path: Path) -> None:
    recorder = ImageRecorder(tmp_path / "logs" / "flight.frames")
    images = [image(stamp_us) for stamp_us in (0, 48_000, 12_345_678)]
    for each in images:
        recorder.record(each)
    recorder.close()
    names = sorted(path.name for path in recorder.folder.iterdir())
    assert names == ["000000000000.png", "000000048000.png", "000012345678.png"]
    for name, each in zip(names, images, strict=True):
        np.testing.assert_array_equal(read_rgb(recorder.folder / name), each.rgb)
    assert recorder.failure is None


def test_takes_the_place_of_an_earlier_recording_only(tmp_path: Path) -> None:
    (tmp_path / "000000000007.png").write_bytes(b"earlier")
    (tmp_path / "notes.png").write_bytes(b"mine")
    recorder = ImageRecorder(tmp_path)
    recorder.record(image(1))
    recorder.close()
    assert {path.name for path in tmp_path.iterdir()} == {"000000000001.png", "notes.png"}


def test_a_slow_disk_costs_images_not_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recorder_module, "QUEUED_BYTES", 4 * image(0).rgb.nbytes)
    folder = tmp_path / "flight.frames"
    recorder = ImageRecorder(folder)
    blocked = folder / f"000000000000.png.{os.getpid()}.part"
    os.mkfifo(blocked)  # writing waits until somebody reads
    for stamp_us in range(10):
        recorder.record(image(stamp_us))
    assert recorder.failure is not None
    assert "too slow" in recorder.failure
    reader = threading.Thread(target=blocked.read_bytes, daemon=True)
    reader.start()
    recorder.close()
    reader.join(WAIT_S)
    written = sorted(int(path.stem) for path in folder.glob("*.png"))
    assert written == [0, 1, 2, 3]


def test_an_image_larger_than_the_queue_is_still_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recorder_module, "QUEUED_BYTES", 1)
    recorder = ImageRecorder(tmp_path)
    recorder.record(image(5))
    recorder.close()
    assert recorder.failure is None
    assert (tmp_path / "000000000005.png").exists()


def test_a_full_disk_ends_the_recording_and_says_so(tmp_path: Path) -> None:
    recorder = ImageRecorder(tmp_path / "flight.frames")
    with small_disk(100):
        for stamp_us in range(3):
            recorder.record(image(stamp_us))
        recorder.close()
    assert recorder.failure == f"the recording {recorder.folder} ends here: File too large"
    assert not recorder.folder.exists()


def test_the_last_of_the_disk_is_the_logs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    recorder = ImageRecorder(tmp_path / "flight.frames")
    recorder.record(image(1))
    with contextlib.closing(recorder):
        deadline_s = time.monotonic() + WAIT_S
        while not (recorder.folder / "000000000001.png").exists():
            assert time.monotonic() < deadline_s
        monkeypatch.setattr(recorder_module, "RESERVE_BYTES", 1 << 62)
        recorder.record(image(2))
    assert [path.name for path in recorder.folder.iterdir()] == ["000000000001.png"]
    assert recorder.failure is not None
    assert recorder.failure.startswith(f"the recording {recorder.folder} ends here: the last")


def test_leaves_no_empty_folder(tmp_path: Path) -> None:
    recorder = ImageRecorder(tmp_path / "flight.frames")
    recorder.close()
    assert not recorder.folder.exists()


def test_a_folder_that_cannot_be_is_refused(tmp_path: Path) -> None:
    (tmp_path / "flight.frames").write_text("a file")
    with pytest.raises(UsageError, match=r"cannot record frames in .*flight\.frames: File exists"):
        ImageRecorder(tmp_path / "flight.frames")
