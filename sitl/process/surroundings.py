"""What is put around a vehicle whoever flies it: its world, its camera's facts, video and log."""

import os
import sys
from collections.abc import Callable
from contextlib import ExitStack, closing

from sitl.errors import UsageError
from sitl.flown_vehicle import SimulationConfig
from sitl.mavlink.components.camera_component import CameraFacts
from sitl.mavlink.links.link import Guard
from sitl.mavlink.wire.tlog import TlogWriter
from sitl.process.options.command_line import Options
from sitl.process.server import Server
from sitl.process.streams.video import VideoSender
from sitl.sensors.camera.camera import SIZE_PX
from sitl.sensors.camera.feed import CAMERA_RATE_HZ


def make_config(options: Options) -> SimulationConfig:
    """Say what the flight depends on; raises UsageError where a window cannot be opened."""
    if options.gui and sys.platform == "linux" and not os.environ.get("DISPLAY"):
        raise UsageError("--gui needs a display: DISPLAY is not set")
    return SimulationConfig(
        seed=options.seed,
        track_seed=options.track_seed,
        noise_m=options.noise_m,
        direction=options.direction,
        laps=options.laps,
        home=options.home,
        gui=options.gui,
        perfect_estimate=options.perfect_estimate,
        settled_s=options.ready_after_s,
        conditions=options.conditions,
    )


def describe_camera(stream_uri: str, options: Options) -> CameraFacts:
    """Say what the camera tells about itself."""
    return CameraFacts(
        stream_uri=stream_uri,
        width_px=SIZE_PX,
        height_px=SIZE_PX,
        field_of_view_deg=round(options.conditions.scenery.field_of_view_deg),
        rate_hz=float(CAMERA_RATE_HZ),
    )


def keep_records(
    server: Server,
    options: Options,
    guard: Guard,
    stack: ExitStack,
    unix_epoch_us: int,
    clock: Callable[[], int],
) -> None:
    """Send the video, count refusals and write the log, where they are asked for.

    `clock` is vehicle time in us; `stack` closes them. Raises UsageError for a path that can't be.
    """
    if options.video is not None:
        video = VideoSender(options.video, size_px=SIZE_PX, rate_hz=CAMERA_RATE_HZ)
        server.send_video(stack.enter_context(closing(video)))
    server.watch_refusals(guard.refusals)
    if options.log is not None:
        tlog = TlogWriter(options.log, unix_epoch_us=unix_epoch_us, clock=clock)
        server.keep_log(stack.enter_context(closing(tlog)))
