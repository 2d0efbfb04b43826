"""The film of a flight: one picture an image, in its time, and one line where there are none."""

import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from flightstack.logs import read
from flightstack.logs.cli import main
from flightstack.logs.flight.course import CourseGate
from flightstack.logs.flight.flight import Flight
from flightstack.logs.seen import find_seen
from flightstack.logs.video.drawing import GATE
from flightstack.logs.video.overlay import draw_gate
from tests.unit.flightstack.logs.made_flights import make_flight


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = tmp_path / "flight.tlog"
    path.write_bytes(make_flight(4.0))
    images = path.with_suffix(".frames")
    images.mkdir()
    for shade, stamp_us in enumerate(Flight(read(path)).decisions.stamp_us.tolist()):
        image = np.full((64, 64, 3), (10, 20, 3 * shade), dtype=np.uint8)
        assert cv2.imwrite(str(images / f"{stamp_us:012d}.png"), image)
    return path


def test_a_film_has_one_picture_an_image_at_its_time(log: Path) -> None:
    av = pytest.importorskip("av")
    assert main(["video", str(log)]) == 0
    stamps = find_seen(Flight(read(log))).stamp_us
    with av.open(str(log.with_suffix(".mp4"))) as film:
        times = [float(picture.time) for picture in film.decode(video=0)]
    np.testing.assert_allclose(times, (stamps - stamps[0]) * 1e-6, atol=1e-3)


def test_every_image_has_its_decision_and_its_place(log: Path) -> None:
    flight = Flight(read(log))
    seen = find_seen(flight)
    assert seen.decision.tolist() == list(range(len(flight.decisions)))
    assert np.isfinite(seen.position_ned).all()
    late = seen.time_us - flight.decisions.time_us
    assert (np.abs(late) < 10_000).all()  # the decision left 4 ms after its image
    passed = [event for event in flight.course_events if event.kind == "passed"]
    assert seen.gates_passed[-1] == len(passed) > 0


def test_a_log_without_images_is_refused_in_one_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "bare.tlog"
    path.write_bytes(make_flight(1.0))
    assert main(["video", str(path)]) == 2
    assert "--record-frames" in capsys.readouterr().err


def test_flights_become_a_dataset_row_by_row(log: Path, tmp_path: Path) -> None:
    av, parquet = pytest.importorskip("av"), pytest.importorskip("pyarrow.parquet")
    folder = tmp_path / "dataset"
    assert main(["dataset", str(log), str(log), "-o", str(folder)]) == 0
    decisions = Flight(read(log)).decisions
    count = len(decisions)
    info = json.loads((folder / "meta" / "info.json").read_text())
    assert (info["total_episodes"], info["total_frames"]) == (2, 2 * count)
    assert info["fps"] == 20  # of steps of 40 and 60 ms
    table = parquet.read_table(folder / "data" / "chunk-000" / "file-001.parquet")
    np.testing.assert_allclose(table["action"].to_pylist(), decisions.command, atol=1e-6)
    assert table["index"].to_pylist() == list(range(count, 2 * count))
    told = np.hstack([decisions.aleatoric_std, decisions.epistemic_std, decisions.perceptual_std])
    np.testing.assert_allclose(table["uncertainty"].to_pylist(), told, atol=1e-6)
    film = next(folder.glob("videos/*/chunk-000/file-001.mp4"))
    with av.open(str(film)) as opened:
        blue = [picture.to_ndarray(format="rgb24")[32, 32, 0] for picture in opened.decode()]
    assert len(blue) == count
    assert main(["dataset", str(log), "-o", str(folder)]) == 2  # never over another


def test_a_gate_is_drawn_where_it_is_seen() -> None:
    ahead = CourseGate(index=0, centre_ned=(2.0, 5.0, -3.0), yaw_rad=np.pi / 2, half_opening_m=0.5)
    canvas = np.zeros((200, 200, 3), dtype=np.uint8)
    east = np.array([0.0, 0.0, np.pi / 2])
    draw_gate(canvas, ahead, np.array([2.5, 0.0, -3.0]), east)  # 5 m ahead, 0.5 m to the right
    rows, columns = np.nonzero((canvas == GATE).all(axis=2))
    north_is_left = 100 + 100 * 0.5 / 5.0
    assert columns.mean() == pytest.approx(north_is_left, abs=2)
    assert rows.mean() == pytest.approx(100, abs=2)
    assert np.ptp(columns) == pytest.approx(2 * 0.5 / 5 * 100, abs=3)
