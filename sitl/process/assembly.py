"""Put a vehicle together: the simulation, its camera stream, its endpoint, and the loop."""

import os
import sys
from collections.abc import Sequence
from contextlib import ExitStack, closing

from sitl.autopilot.parameters import Parameters, ParameterType
from sitl.errors import UsageError
from sitl.flown_vehicle import SimulationConfig
from sitl.mavlink.components.camera_component import CameraFacts
from sitl.mavlink.endpoint import Endpoint
from sitl.mavlink.links.link import Guard, Link
from sitl.mavlink.servers.files.storage import Storage
from sitl.mavlink.wire.tlog import TlogWriter
from sitl.process.options.command_line import Options
from sitl.process.options.parameter_file import ParameterFile
from sitl.process.server import Server
from sitl.process.streams.camera_stream import CameraStream
from sitl.process.streams.video import VideoSender
from sitl.process.vehicle_folder import vehicle_folder
from sitl.sensors.camera.camera import FIELD_OF_VIEW_DEG, SIZE_PX
from sitl.sensors.camera.feed import CAMERA_RATE_HZ
from sitl.simulation import Simulation


def assemble(
    options: Options, links: Sequence[Link], guard: Guard, unix_epoch_us: int, stack: ExitStack
) -> tuple[Server, CameraStream]:
    """Build everything behind open links; `stack` closes it.

    Raises:
        LinkError: the camera's port cannot be had.
        UsageError: a parameter, the track's noise, a path or the display cannot be.

    """
    stream = stack.enter_context(closing(CameraStream(options.camera_port)))
    simulation = stack.enter_context(closing(_make_simulation(options)))
    kept = _set_parameters(options, simulation.parameters)
    endpoint = Endpoint(
        simulation,
        links,
        system=options.system,
        camera=_describe_camera(stream),
        unix_epoch_us=unix_epoch_us,
        guard=guard,
        storage=stack.enter_context(
            closing(_make_storage(options, simulation, unix_epoch_us, stack))
        ),
    )
    stack.callback(endpoint.close)
    server = Server(
        simulation,
        endpoint,
        links,
        stream,
        speed_factor=options.speed_factor,
        lockstep=options.lockstep,
    )
    if options.video is not None:
        video = VideoSender(options.video, size_px=SIZE_PX, rate_hz=CAMERA_RATE_HZ)
        server.send_video(stack.enter_context(closing(video)))
    server.watch_refusals(guard.refusals)
    if kept is not None:
        server.each_second(kept.save)
        stack.callback(kept.save)
    if options.log is not None:
        tlog = TlogWriter(
            options.log, unix_epoch_us=unix_epoch_us, clock=lambda: simulation.time_us
        )
        server.keep_log(stack.enter_context(closing(tlog)))
    return server, stream


def _make_simulation(options: Options) -> Simulation:
    if options.gui and sys.platform == "linux" and not os.environ.get("DISPLAY"):
        raise UsageError("--gui needs a display: DISPLAY is not set")
    return Simulation(
        SimulationConfig(
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
    )


def _set_parameters(options: Options, parameters: Parameters) -> ParameterFile | None:
    """Take the kept parameters, then those of the environment."""
    kept = None if options.params is None else ParameterFile(options.params, parameters)
    for name, text in options.parameters.items():
        parameters.set_from_text(name, text)
    parameters.set("MAV_SYS_ID", options.system)
    return kept


def _make_storage(
    options: Options, simulation: Simulation, unix_epoch_us: int, stack: ExitStack
) -> Storage:
    folder = options.files
    if folder is None:
        folder = stack.enter_context(vehicle_folder())
    return Storage(
        folder,
        parameters=_describe_parameters(simulation.parameters),
        unix_epoch_us=unix_epoch_us,
        clock=lambda: simulation.time_us,
    )


def _describe_parameters(parameters: Parameters) -> list[dict[str, str | float]]:
    """Put the parameters into the words of MAVLink's parameter metadata."""
    return [
        {
            "name": spec.name,
            "type": "Int32" if spec.type is ParameterType.INT32 else "Float",
            "group": spec.name.partition("_")[0],
            "default": spec.default,
            "min": spec.minimum,
            "max": spec.maximum,
            "units": spec.unit,
        }
        for spec in map(parameters.specification, parameters.names())
    ]


def _describe_camera(stream: CameraStream) -> CameraFacts:
    return CameraFacts(
        stream_uri=stream.uri,
        width_px=SIZE_PX,
        height_px=SIZE_PX,
        field_of_view_deg=round(FIELD_OF_VIEW_DEG),
        rate_hz=float(CAMERA_RATE_HZ),
    )
