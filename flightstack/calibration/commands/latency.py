"""Measure how late images are, from a recording in which the vehicle was turned by hand."""

import argparse
import json
from dataclasses import asdict
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from flightstack.calibration.image_turns import measure_turns
from flightstack.calibration.lag import Floats, LatencyEstimate, find_latency
from flightstack.calibration.recordings import read_frames
from flightstack.logs import read
from flightstack.logs.columns.senders import find_participants, main_autopilot, of_vehicle

MIN_GYRO_HZ = 20.0  # of HIGHRES_IMU


def run(options: argparse.Namespace) -> str:
    """Measure; return what there is to say."""
    frames = options.frames or options.log.with_suffix(".frames")
    estimate = find_latency(measure_turns(read_frames(frames)), *_gyro(options.log))
    return json.dumps(asdict(estimate)) if options.json else _told(estimate)


def _gyro(log: Path) -> tuple[NDArray[np.int64], Floats]:
    """Return times, vehicle time in us, and yaw rates of the body, rad/s.

    The gyro as it is, where its stream is quick enough; else the rate at which the estimated yaw
    changes. ATTITUDE.yawspeed is neither: a low pass has made it some milliseconds late.
    """
    whole = read(log)
    vehicle = main_autopilot(find_participants(whole), None)
    sensed = of_vehicle(whole["HIGHRES_IMU"], vehicle)
    time_us, first = np.unique(sensed["time_usec"].astype(np.int64), return_index=True)
    if len(time_us) > 1 and 1e6 * (len(time_us) - 1) / np.ptp(time_us) >= MIN_GYRO_HZ:
        return time_us, sensed["zgyro"][first].astype(np.float64)
    told = of_vehicle(whole["ATTITUDE"], vehicle)
    time_us, first = np.unique(told["time_boot_ms"].astype(np.int64) * 1000, return_index=True)
    yaw = np.unwrap(told["yaw"][first].astype(np.float64))
    return time_us, np.gradient(yaw, time_us / 1e6) if len(yaw) > 1 else yaw


def _told(estimate: LatencyEstimate) -> str:
    low, high, latency = (1000 * s for s in (estimate.low_s, estimate.high_s, estimate.latency_s))
    return (
        f"images are {latency:.0f} ms late (95 %: {low:.0f} to {high:.0f} ms; correlation "
        f"{estimate.correlation:.3f} over {estimate.turns} images, {estimate.lasted_s:.0f} s)\n"
        f"--camera-latency-s {max(0.0, estimate.latency_s):.3f}, plus that of the recording, if any"
    )
