"""Run the vehicle or the companion timed: `profiled.py ROLE parts|whole REPORT [option ...]`.

Started by flying.py. The report is JSON: the stopwatch's snapshots, and for the companion the
times of its decisions. Timing every part costs time itself; `whole` times the process alone.
"""

import json
import sys
import time
from dataclasses import asdict
from pathlib import Path
from typing import Any

from scripts.bench.stopwatch import Stopwatch


def time_vehicle(stopwatch: Stopwatch, *, parts: bool) -> None:
    """Name the vehicle's parts, or the one thing that it does with each image."""
    from sitl.process.quiet import quiet_outputs  # noqa: PLC0415 - only this role loads it

    with quiet_outputs():
        import pybullet  # noqa: F401, PLC0415 - it greets on standard output
    from sitl.autopilot.autopilot import Autopilot  # noqa: PLC0415
    from sitl.mavlink.endpoint import Endpoint  # noqa: PLC0415
    from sitl.process.server import Server  # noqa: PLC0415
    from sitl.process.streams import camera_stream  # noqa: PLC0415
    from sitl.sensors.camera.camera import Camera  # noqa: PLC0415
    from sitl.simulation import Simulation  # noqa: PLC0415
    from sitl.world.world import World  # noqa: PLC0415

    stopwatch.watch(camera_stream.CameraStream, "publish", "camera stream")
    if not parts:
        return
    stopwatch.watch(Server, "_run_lockstep", "loop")
    stopwatch.watch(Simulation, "step", "referee, estimate")
    stopwatch.watch(World, "step", "physics")
    stopwatch.watch(Autopilot, "step", "autopilot")
    stopwatch.watch(Camera, "render", "rendering")
    stopwatch.watch(camera_stream, "part", "image coding")
    stopwatch.watch(camera_stream.CameraStream, "serve", "camera stream")
    for name in ("publish", "publish_trigger", "receive"):
        stopwatch.watch(Endpoint, name, "MAVLink")


def time_companion(stopwatch: Stopwatch, decided: list[tuple[float, int]], *, parts: bool) -> None:
    """Name the companion's parts, and note when it decides: wall time, image stamp."""
    from flightstack.camera import multipart  # noqa: PLC0415 - only this role loads it
    from flightstack.companion import loop, pipeline  # noqa: PLC0415
    from flightstack.decision import strategies  # noqa: PLC0415
    from flightstack.mavlink.link import Link  # noqa: PLC0415
    from flightstack.mavlink.tlog import TlogWriter  # noqa: PLC0415
    from flightstack.policy.ensemble import PolicyEnsemble  # noqa: PLC0415

    stopwatch.watch(pipeline.Pipeline, "decide", "perception")
    if parts:
        stopwatch.watch(loop.FlightLoop, "_turn", "loop")
        stopwatch.watch(PolicyEnsemble, "predict", "policies")
        for strategy in vars(strategies).values():
            if isinstance(strategy, type) and "decide" in vars(strategy):
                stopwatch.watch(strategy, "decide", "decision")
        stopwatch.watch(Link, "drain", "MAVLink")
        stopwatch.watch(Link, "send", "MAVLink")
        for name in ("append", "flush", "flush_if_due"):
            stopwatch.watch(TlogWriter, name, "log")
        stopwatch.watch(multipart, "decode_rgb", "image decoding")
        stopwatch.watch(multipart.MultipartSource, "read", "camera stream")

    decide = pipeline.Pipeline.decide

    def noted(self: Any, image: Any) -> Any:
        decided.append((time.monotonic(), image.stamp_us))
        return decide(self, image)

    pipeline.Pipeline.decide = noted  # type: ignore[method-assign]


def main() -> int:
    """Run the role's command line and write the report, however it ends."""
    role, detail, report, *options = sys.argv[1:]
    stopwatch = Stopwatch()
    decided: list[tuple[float, int]] = []
    if role == "vehicle":
        time_vehicle(stopwatch, parts=detail == "parts")
        from sitl.process.cli import main as run  # noqa: PLC0415
    else:
        time_companion(stopwatch, decided, parts=detail == "parts")
        from flightstack.companion.cli import main as run  # noqa: PLC0415
    try:
        return run(options)
    finally:
        snapshots = [asdict(snapshot) for snapshot in stopwatch.snapshots]
        Path(report).write_text(json.dumps({"snapshots": snapshots, "decided": decided}))


if __name__ == "__main__":
    sys.exit(main())
