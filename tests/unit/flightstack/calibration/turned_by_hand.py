"""A recording of a vehicle that is turned by hand: the simulator's camera, and a gyro."""

import math
import struct
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from pymavlink.dialects.v20 import common

from flightstack.arrays import Rgb
from sitl.sensors.camera.camera import Camera
from sitl.sensors.camera.look import draw_look
from sitl.world.track import make_track

LASTS_S, CAMERA_HZ, GYRO_HZ = 14.0, 20.0, 100.0
BOOT_US = 30_000_000
LOOK = draw_look(np.random.default_rng(0))
EYE_NED = (-6.0, -3.0, -2.0)  # m: where gates stand on both sides

Floats = NDArray[np.float64]


def yaw_rad(time_s: Floats) -> Floats:
    """To and fro by up to a quarter, as hands do it: not always alike."""
    return np.asarray(0.7 * np.sin(2.1 * time_s) + 0.35 * np.sin(3.7 * time_s + 1.0))


def frames(latency_s: float, *, jitter_s: float = 0.0) -> Iterator[tuple[int, Rgb]]:
    """Images stamped later than they were taken, some more and some less."""
    rng = np.random.default_rng(1)
    camera = Camera(make_track(0, radius_noise_m=0, height_noise_m=0, direction="cw").gates, LOOK)
    try:
        times_s = np.arange(0.5, LASTS_S - 1.0, 1.0 / CAMERA_HZ)
        for taken_s, yaw in zip(times_s.tolist(), yaw_rad(times_s).tolist(), strict=True):
            rgb = camera.render(EYE_NED, (math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)))
            stamp_s = taken_s + latency_s + rng.uniform(-jitter_s, jitter_s)
            yield BOOT_US + round(stamp_s * 1e6), rgb
    finally:
        camera.close()


def gyro() -> tuple[NDArray[np.int64], Floats]:
    """Times in us and yaw rates in rad/s, with a bias and noise."""
    time_s = np.arange(0.0, LASTS_S, 1.0 / GYRO_HZ)
    rng = np.random.default_rng(2)
    rate = np.gradient(yaw_rad(time_s), time_s) + 0.01 + rng.normal(0.0, 0.01, len(time_s))
    return BOOT_US + np.round(time_s * 1e6).astype(np.int64), rate


def write_recording(log: Path, latency_s: float, *, with_imu: bool) -> None:
    """Write a tlog and LOG.frames, as the companion's --record-frames does.

    ATTITUDE.yawspeed is wrong: nobody should go by it.
    """
    codec = common.MAVLink(None, srcSystem=1, srcComponent=1)
    beat = common.MAVLink_heartbeat_message(2, 12, 29, 0, 3, 3)
    records = [(0, beat.pack(codec))]
    times_us, rates = gyro()
    yaws = yaw_rad((times_us - BOOT_US) / 1e6)
    for time_us, rate, yaw in zip(times_us, rates, yaws, strict=True):
        told = common.MAVLink_attitude_message(int(time_us) // 1000, 0, 0, yaw, 0, 0, 0.1)
        records.append((int(time_us), told.pack(codec)))
        if with_imu:
            sensed = (0, 0, -9.8, 0, 0, rate, 0, 0, 0, 0, 0, 0, 0)
            imu = common.MAVLink_highres_imu_message(int(time_us), *sensed, 63)
            records.append((int(time_us), imu.pack(codec)))
    log.write_bytes(
        b"".join(struct.pack(">Q", us + 1_700_000_000_000_000) + p for us, p in records)
    )
    folder = log.with_suffix(".frames")
    folder.mkdir()
    for stamp_us, rgb in frames(latency_s):
        cv2.imwrite(str(folder / f"{stamp_us:012d}.png"), rgb[..., ::-1])
