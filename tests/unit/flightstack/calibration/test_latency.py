"""The latency of a simulated camera is found from a recording that was turned by hand."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from flightstack.calibration.cli import main
from flightstack.calibration.image_turns import ImageTurns, measure_turns
from flightstack.calibration.lag import find_latency
from flightstack.errors import UsageError
from tests.unit.flightstack.calibration.turned_by_hand import (
    frames,
    gyro,
    write_recording,
    yaw_rad,
)


def made_turns(latency_s: float, *, noise_rad: float, seed: int) -> ImageTurns:
    """Turns without images: what flow would say, with its errors and now and then nonsense."""
    rng = np.random.default_rng(seed)
    taken_s = np.arange(0.5, 13.0, 0.05)
    angle = np.diff(yaw_rad(taken_s)) + rng.normal(0.0, noise_rad, len(taken_s) - 1)
    angle[rng.random(len(angle)) < 0.03] = 0.0
    stamps = 30_000_000 + np.round((taken_s + latency_s) * 1e6).astype(np.int64)
    return ImageTurns(from_us=stamps[:-1], to_us=stamps[1:], angle_rad=angle)


@pytest.mark.parametrize(("latency_s", "with_imu"), [(0.08, True), (0.15, False)])
def test_the_latency_of_a_camera_is_found_within_5_ms(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], latency_s: float, *, with_imu: bool
) -> None:
    log = tmp_path / "bench.tlog"
    write_recording(log, latency_s, with_imu=with_imu)
    assert main(["latency", str(log), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["latency_s"] == pytest.approx(latency_s, abs=0.005)
    assert found["low_s"] - 0.001 <= latency_s <= found["high_s"] + 0.001
    assert found["high_s"] - found["low_s"] < 0.01
    assert main(["latency", str(log)]) == 0
    assert f"--camera-latency-s {found['latency_s']:.3f}" in capsys.readouterr().out


def test_stamps_that_jitter_cost_little() -> None:
    estimate = find_latency(measure_turns(frames(0.12, jitter_s=0.008)), *gyro())
    assert estimate.latency_s == pytest.approx(0.12, abs=0.005)


def test_the_interval_holds_the_truth_as_often_as_it_says() -> None:
    inside = 0
    for seed in range(20):
        estimate = find_latency(made_turns(0.1, noise_rad=0.02, seed=seed), *gyro())
        inside += estimate.low_s <= 0.1 <= estimate.high_s
    assert inside >= 16  # of 19 that 95 % would be; blocks of a second are few


def test_a_camera_that_is_dated_too_early_has_a_negative_latency() -> None:
    estimate = find_latency(made_turns(-0.04, noise_rad=0.002, seed=0), *gyro())
    assert estimate.latency_s == pytest.approx(-0.04, abs=0.003)


def test_what_says_nothing_is_told() -> None:
    times, rate = gyro()
    turns = made_turns(0.1, noise_rad=0.002, seed=0)
    with pytest.raises(UsageError, match=r"turned by .* rad/s: too little"):
        find_latency(turns, times, rate * 0.05)
    noise = np.random.default_rng(0).normal(0, 0.1, len(turns.angle_rad))
    with pytest.raises(UsageError, match="unlike the gyro"):
        find_latency(replace(turns, angle_rad=noise), times, rate)
    with pytest.raises(UsageError, match=r"only \d s of images and gyro together"):
        find_latency(turns, times[:300], rate[:300])
    with pytest.raises(UsageError, match="neither HIGHRES_IMU nor ATTITUDE"):
        find_latency(turns, times[:0], rate[:0])


def test_a_log_without_frames_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["latency", str(tmp_path / "none.tlog")]) == 2
    assert "none.frames: no recorded frames" in capsys.readouterr().err
